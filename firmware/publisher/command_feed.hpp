// The command channel's messages from the network: through a UDP socket of its own that receives only this
// channel, holds one datagram at a time and allocates nothing, so that no packet can do harm and no flood can
// fill memory.
#pragma once

#include <cstdint>
#include <functional>
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
    std::function<void()> oversized;                             ///< a message larger than a datagram came
    std::function<void()> turn;                                  ///< at least ten times a second
  };

  CommandFeed() = default;
  CommandFeed(const CommandFeed&) = delete;
  CommandFeed& operator=(const CommandFeed&) = delete;
  virtual ~CommandFeed() = default;

  /// Fails if the socket cannot be opened, or the URL is not one of common/wire/lcm_url.hpp.
  static Result<std::unique_ptr<CommandFeed>> open(const std::string& url, const std::string& channel);

  /// Blocks until `stop` is requested, plus at most 0.1 s; calls the handlers on this thread. Throws
  /// std::runtime_error if nothing can be received any more.
  virtual void run(const std::stop_token& stop, const Handlers& handlers) = 0;
};

}  // namespace strobe::firmware
