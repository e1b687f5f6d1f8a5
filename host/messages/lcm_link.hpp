// This host's end of LCM: receives every message of one rig but commands. What comes in by UDP multicast does
// not pass LCM's own receiver (common/wire). Single-threaded; receive() blocks, for its time at most.
#pragma once

#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "common/wire/assembler.hpp"
#include "common/wire/channel_socket.hpp"
#include "host/messages/transport.hpp"

namespace strobe::host {

class LcmLink final : public Transport {
 public:
  /// Fails where LCM cannot be had (no route for multicast, bad URL).
  static Result<std::unique_ptr<LcmLink>> open(const std::string& url, const std::string& rig);

  /// Hands over at most 10,000 messages.
  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver& receiver) override;
  void publish(const std::string& channel, Bytes bytes) override;

 private:
  LcmLink(const std::string& url, const std::string& rig);
  Result<void> listen(const std::string& url, const std::string& rig);
  void handle(const lcm::ReceiveBuffer* buffer, const std::string& channel);
  void hand_over(const std::string& channel, Bytes bytes);
  enum class Taken { message, nothing, failed };
  Taken take();

  lcm::LCM lcm_;
  std::optional<wire::ChannelSocket> socket_;  ///< none where the URL is not one of UDP multicast
  wire::Assembler assembler_;
  std::string rig_channels_, command_channel_;
  const Receiver* receiver_ = nullptr;  ///< while receive() runs
};

}  // namespace strobe::host
