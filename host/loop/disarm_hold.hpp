// Somebody who only watches disarms the rig, and it stays disarmed for a while: between two shots nothing is armed that a
// DISARM could take back, and the series that is under way would arm the next. Single-threaded; never waits.
#pragma once

#include <cstdint>
#include <string>

#include "host/loop/host_loop.hpp"

namespace strobe::host {

class DisarmHold {
 public:
  /// Longer than a series waits for a photograph before it arms the next shot.
  static constexpr Duration kHold = std::chrono::seconds{20};

  explicit DisarmHold(HostLoop& loop) : loop_(loop) {}

  /// Sends a DISARM now. from: who asks, told as a notification with what it means.
  void disarm(const std::string& from);
  /// To be called after each turn of the loop: what is armed meanwhile is disarmed, once each.
  void step();

 private:
  void send(const strobe_msgs::status_t& status);

  HostLoop& loop_;
  HostTime until_;
  std::int64_t token_ = 0;  ///< that was disarmed last
  bool holds_ = false;
};

}  // namespace strobe::host
