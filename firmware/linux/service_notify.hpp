// Notifies the service manager: sd_notify(3)'s protocol, one datagram to $NOTIFY_SOCKET. Without a manager
// every call does nothing. Never blocks; one thread's.
#pragma once

#include <string>
#include <string_view>

#include "common/units/time.hpp"

namespace strobe::firmware {

class ServiceNotify {
 public:
  /// The manager of this process: $NOTIFY_SOCKET (a path, or an abstract name after '@'), $WATCHDOG_USEC and
  /// $WATCHDOG_PID as systemd sets them.
  static ServiceNotify from_environment();
  /// address: "" for none. watchdog: 0 for none.
  ServiceNotify(const std::string& address, Duration watchdog);
  ServiceNotify(ServiceNotify&& other) noexcept;
  ServiceNotify& operator=(ServiceNotify&&) = delete;
  ~ServiceNotify();

  /// E.g. "READY=1\nSTATUS=ready". Lost if the manager does not read.
  void say(std::string_view assignments) const noexcept;

  bool managed() const { return fd_ >= 0; }
  /// The manager expects WATCHDOG=1 at least this often; 0 if it does not.
  Duration watchdog() const { return watchdog_; }

 private:
  int fd_ = -1;
  Duration watchdog_{};
};

}  // namespace strobe::firmware
