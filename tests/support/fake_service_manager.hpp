// A stand-in for systemd's end of sd_notify(3): a socket that services speak to. One thread.
#pragma once

#include <string>
#include <vector>

namespace strobe::testing {

class FakeServiceManager {
 public:
  /// path: of the socket, in a folder of the test's. std::runtime_error if it cannot be made.
  explicit FakeServiceManager(const std::string& path);
  ~FakeServiceManager();
  FakeServiceManager(const FakeServiceManager&) = delete;
  FakeServiceManager& operator=(const FakeServiceManager&) = delete;

  const std::string& path() const { return path_; }
  /// What has come so far, one entry per datagram.
  const std::vector<std::string>& heard();
  /// How many of them begin with the text.
  int count(const std::string& beginning);

 private:
  std::string path_;
  int fd_;
  std::vector<std::string> heard_;
};

}  // namespace strobe::testing
