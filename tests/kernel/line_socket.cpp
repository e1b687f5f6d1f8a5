#include "tests/kernel/line_socket.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace strobe::kernel {

namespace {

[[noreturn]] void give_up(const std::string& what) {
  // A peer that ended with unread input resets the connection.
  if (errno == ECONNRESET || errno == EPIPE) throw PeerGone();
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

bool readable(int fd, std::chrono::milliseconds limit) {
  pollfd waiting{fd, POLLIN, 0};
  return poll(&waiting, 1, static_cast<int>(limit.count())) > 0;
}

}  // namespace

LineSocket::LineSocket(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof address.sun_path)
    throw std::runtime_error("path too long: " + path.string());
  std::memcpy(address.sun_path, path.c_str(), path.string().size() + 1);
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (listener_ < 0 || bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_, 1) != 0)
    give_up(path.string());
}

LineSocket::~LineSocket() {
  if (peer_ >= 0) close(peer_);
  if (listener_ >= 0) close(listener_);
}

void LineSocket::accept(std::chrono::milliseconds limit) {
  if (!readable(listener_, limit)) throw std::runtime_error("nobody connected");
  peer_ = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
  if (peer_ < 0) give_up("accept");
}

void LineSocket::send(const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = ::send(peer_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno != EINTR) give_up("send");
    if (n > 0) sent += static_cast<std::size_t>(n);
  }
}

std::optional<std::string> LineSocket::receive(std::chrono::milliseconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  for (;;) {
    if (const std::size_t length = waiting_.find('\n'); length != std::string::npos) {
      std::string line = waiting_.substr(0, length);
      waiting_.erase(0, length + 1);
      if (!line.empty() && line.back() == '\r') line.pop_back();
      return line;
    }
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    if (!readable(peer_, std::max(left, std::chrono::milliseconds(0)))) return std::nullopt;
    char part[4096];
    const ssize_t n = read(peer_, part, sizeof part);
    if (n == 0) throw PeerGone();
    if (n < 0 && errno != EINTR) give_up("read");
    if (n > 0) waiting_.append(part, static_cast<std::size_t>(n));
  }
}

}  // namespace strobe::kernel
