// This host's end of LCM: receives every message of one rig but commands. LCM only sends: what comes in does
// not pass its own receiver (common/wire). Single-threaded; receive() blocks, for its time at most.
#pragma once

#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <string>

#include "common/result.hpp"
#include "common/wire/assembler.hpp"
#include "common/wire/channel_socket.hpp"
#include "common/wire/lcm_url.hpp"
#include "host/messages/transport.hpp"

namespace strobe::host {

class LcmLink final : public Transport {
 public:
  /// Fails where LCM cannot be had (no route for multicast) or the URL is not one of common/wire/lcm_url.hpp.
  static Result<std::unique_ptr<LcmLink>> open(const std::string& url, const std::string& rig);

  /// Takes in at most 10,000 datagrams.
  bool receive(std::chrono::milliseconds max_wait, std::span<const int> descriptors,
               const Receiver& receiver) override;
  std::string sender() const override { return wire::address_of(sender_); }
  void publish(const std::string& channel, Bytes bytes) override;

 private:
  LcmLink(const wire::LcmUrl& url, wire::ChannelSocket socket, const std::string& rig);
  void hand_over(const std::string& channel, Bytes bytes);
  bool take();  ///< false: nothing is waiting

  lcm::LCM lcm_;
  wire::ChannelSocket socket_;
  wire::Assembler assembler_;
  std::uint64_t sender_ = 0;
  std::string rig_channels_, command_channel_;
  const Receiver* receiver_ = nullptr;  ///< while receive() runs
};

}  // namespace strobe::host
