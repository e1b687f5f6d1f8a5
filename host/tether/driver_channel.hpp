// A driver's end of its conversation with strobe: requests from standard input, events to standard output.
// Single-threaded; blocks in wait() only, and in send() while strobe does not read.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/units/time.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::tether {

class DriverChannel {
 public:
  /// The descriptors stay the caller's.
  explicit DriverChannel(int input = 0, int output = 1) : input_(input), output_(output) {}

  /// The next request; a line that is none is answered with FailedEvent. Never waits. Returns nullopt if
  /// there is none.
  std::optional<Request> next();
  /// Nobody listens any more: the driver is to end.
  bool closed() const { return closed_; }
  /// Waits for a request, for one of the descriptors, or so long.
  void wait(std::span<const int> descriptors, Duration longest) const;
  void send(const Event& event);

 private:
  static constexpr std::size_t kMaxLine = 1 << 20;
  void receive();

  int input_, output_;
  std::string received_;
  bool closed_ = false;
};

}  // namespace strobe::tether
