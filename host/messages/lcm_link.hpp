// This host's end of LCM: every message of one rig but commands in, commands and readouts out. What comes in
// by UDP multicast does not pass LCM's own receiver (common/wire). One thread's; blocks in wait().
#pragma once

#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/readout_t.hpp>

#include "common/result.hpp"
#include "common/wire/assembler.hpp"
#include "common/wire/channel_socket.hpp"

namespace strobe::host {

class LcmLink {
 public:
  /// What to do with a message as it came: channel, bytes. Must not throw.
  using Receiver = std::function<void(const std::string&, const void*, std::size_t)>;

  /// Fails where LCM cannot be had (no route for multicast, bad URL).
  static Result<std::unique_ptr<LcmLink>> open(const std::string& url, const std::string& rig,
                                               Receiver receiver);

  /// Handles one message, or returns after the time, or as soon as one of the other descriptors is readable.
  /// False: LCM cannot receive any more.
  bool wait(int milliseconds, std::span<const int> others = {});
  /// Handles what is there without waiting, at most 10,000 messages.
  bool drain();

  /// A command under seal (common/authentication/seal.hpp).
  void publish_command(std::span<const std::uint8_t> sealed);
  void publish(const strobe_msgs::readout_t& readout);
  void publish(const strobe_msgs::frame_t& frame);

 private:
  LcmLink(const std::string& url, const std::string& rig, Receiver receiver);
  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  /// False: nothing is waiting.
  bool take_datagram();
  Result<void> listen(const std::string& url, const std::string& rig);

  lcm::LCM lcm_;
  std::optional<wire::ChannelSocket> socket_;  ///< none where the URL is not one of UDP multicast
  wire::Assembler assembler_;
  Receiver receiver_;
  std::string rig_channels_, command_channel_, readout_channel_, frame_channel_;
};

}  // namespace strobe::host
