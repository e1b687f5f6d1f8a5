#include "tests/support/fake_service_manager.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace strobe::testing {

FakeServiceManager::FakeServiceManager(const std::string& path)
    : path_(path), fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) throw std::runtime_error("too long for a socket: " + path);
  std::memcpy(address.sun_path, path.data(), path.size());
  if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    throw std::runtime_error(path + ": " + std::strerror(errno));
}

FakeServiceManager::~FakeServiceManager() {
  close(fd_);
  unlink(path_.c_str());
}

const std::vector<std::string>& FakeServiceManager::heard() {
  char text[4096];
  for (ssize_t size = 0; (size = recv(fd_, text, sizeof text, 0)) >= 0;)
    heard_.emplace_back(text, static_cast<std::size_t>(size));
  return heard_;
}

int FakeServiceManager::count(const std::string& beginning) {
  const auto& all = heard();
  return static_cast<int>(std::count_if(
      all.begin(), all.end(), [&](const std::string& text) { return text.rfind(beginning, 0) == 0; }));
}

}  // namespace strobe::testing
