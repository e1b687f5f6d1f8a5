#include "host/tether/driver_channel.hpp"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <vector>

namespace strobe::tether {
namespace {

bool readable(int descriptor) {
  pollfd poll_for{descriptor, POLLIN, 0};
  return poll(&poll_for, 1, 0) > 0;
}

}  // namespace

void DriverChannel::receive() {
  std::array<char, 4096> buffer{};
  while (!closed_ && readable(input_)) {
    const ssize_t n = read(input_, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0 || received_.size() > kMaxLine) {
      closed_ = true;
    } else {
      received_.append(buffer.data(), static_cast<std::size_t>(n));
    }
  }
}

std::optional<Request> DriverChannel::next() {
  receive();
  for (std::size_t end = received_.find('\n'); end != std::string::npos; end = received_.find('\n')) {
    const std::string line = received_.substr(0, end);
    received_.erase(0, end + 1);
    auto request = parse_request(line);
    if (request) return *request;
    send(FailedEvent{"no request: " + request.error().message});
  }
  return std::nullopt;
}

void DriverChannel::wait(std::span<const int> descriptors, Duration longest) const {
  std::vector<pollfd> poll_for{{input_, POLLIN, 0}};
  for (const int descriptor : descriptors) poll_for.push_back({descriptor, POLLIN, 0});
  const auto whole_ms = std::chrono::ceil<std::chrono::milliseconds>(longest).count();
  poll(poll_for.data(), poll_for.size(), static_cast<int>(whole_ms));
}

void DriverChannel::send(const Event& event) {
  const std::string line = to_line(event) + "\n";
  for (std::size_t sent = 0; sent < line.size() && !closed_;) {
    const ssize_t n = write(output_, line.data() + sent, line.size() - sent);
    if (n > 0) {
      sent += static_cast<std::size_t>(n);
    } else if (errno != EINTR) {
      closed_ = true;
    }
  }
}

}  // namespace strobe::tether
