#include "firmware/linux/service_notify.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace strobe::firmware {

namespace {

std::int64_t number_in(const char* variable) {
  const char* text = std::getenv(variable);
  std::int64_t number = 0;
  if (text == nullptr) return 0;
  const char* end = text + std::strlen(text);
  return std::from_chars(text, end, number).ptr == end ? number : 0;
}

}  // namespace

ServiceNotify ServiceNotify::from_environment() {
  const char* address = std::getenv("NOTIFY_SOCKET");
  const std::int64_t watched = number_in("WATCHDOG_PID");
  const bool for_us = watched == 0 || watched == getpid();
  const std::int64_t microseconds_allowed = for_us ? number_in("WATCHDOG_USEC") : 0;
  return ServiceNotify(address == nullptr ? "" : address, microseconds(microseconds_allowed));
}

ServiceNotify::ServiceNotify(const std::string& address, Duration watchdog) : watchdog_(watchdog) {
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  if (address.empty() || address.size() >= sizeof to.sun_path) return;
  std::memcpy(to.sun_path, address.data(), address.size());
  if (address[0] == '@') to.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address.size());
  fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0 || connect(fd_, reinterpret_cast<const sockaddr*>(&to), size) == 0) return;
  close(fd_);
  fd_ = -1;
}

ServiceNotify::ServiceNotify(ServiceNotify&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), watchdog_(other.watchdog_) {}

ServiceNotify::~ServiceNotify() {
  if (fd_ >= 0) close(fd_);
}

void ServiceNotify::say(std::string_view assignments) const noexcept {
  if (fd_ < 0) return;
  // Lost where the manager does not read: there is nobody else to tell.
  [[maybe_unused]] const ssize_t sent = send(fd_, assignments.data(), assignments.size(), MSG_NOSIGNAL);
}

}  // namespace strobe::firmware
