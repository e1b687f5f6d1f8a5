// The command channel's messages as they come from the network: from a UDP socket of its own, which takes
// nothing but this channel, holds one datagram at a time and allocates nothing, so that no packet can harm
// and no flood can grow; or, where the LCM URL is not one of UDP multicast, by LCM's subscription.
#pragma once

#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <string>

#include "common/result.hpp"

namespace strobe::firmware {

class CommandFeed {
 public:
  struct Handlers {
    std::function<void(std::span<const std::uint8_t>)> message;  ///< must not throw
    std::function<void()> oversized;  ///< one came that is larger than a datagram holds
    std::function<void()> turn;       ///< at least ten times a second
  };

  CommandFeed() = default;
  CommandFeed(const CommandFeed&) = delete;
  CommandFeed& operator=(const CommandFeed&) = delete;
  virtual ~CommandFeed() = default;

  /// lcm: opened with the same URL; must outlive the feed. Fails where the socket cannot be had.
  static Result<std::unique_ptr<CommandFeed>> open(lcm::LCM& lcm, const std::string& url,
                                                   const std::string& channel);

  /// Until asked to stop, which takes up to 0.1 s. Blocks; calls the handlers on this thread.
  /// std::runtime_error: nothing can be received any more.
  virtual void run(const std::stop_token& stop, const Handlers& handlers) = 0;
};

}  // namespace strobe::firmware
