// One end of a stream socket that speaks in lines, to a program that this one waits for. Failures are
// std::runtime_error, PeerGone where the other side has ended. One thread may send while another receives.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

namespace strobe::kernel {

class PeerGone : public std::runtime_error {
 public:
  PeerGone() : std::runtime_error("the other side is gone") {}
};

class LineSocket {
 public:
  /// Listens on a Unix socket at `path`; the other side connects to it.
  explicit LineSocket(const std::filesystem::path& path);
  ~LineSocket();
  LineSocket(const LineSocket&) = delete;
  LineSocket& operator=(const LineSocket&) = delete;

  /// Waits for the other side.
  void accept(std::chrono::milliseconds limit);

  void send(const std::string& text);

  /// The next line without its end; nothing if none came in time.
  std::optional<std::string> receive(std::chrono::milliseconds limit);

 private:
  int listener_ = -1, peer_ = -1;
  std::string waiting_;
};

}  // namespace strobe::kernel
