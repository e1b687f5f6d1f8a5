// A camera's driver as strobe runs it: started as a child, spoken to in lines. One that ends, says what is no
// event, or says too much at once is ended and told. Starts processes; never waits but for its end, a second
// at most; single-threaded.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/result.hpp"
#include "host/tether/driver_messages.hpp"

namespace strobe::tether {

class CameraDriver {
 public:
  /// kind: "genicam" or "gphoto2". Fails with one line if its driver is not installed.
  static Result<std::filesystem::path> find(const std::string& kind);
  static Result<std::unique_ptr<CameraDriver>> start(const std::filesystem::path& program);
  /// Ends it.
  ~CameraDriver();
  CameraDriver(const CameraDriver&) = delete;
  CameraDriver& operator=(const CameraDriver&) = delete;

  void send(const Request& request);
  /// What it has said since; never waits.
  std::vector<Event> take_events();
  /// Readable when take_events() may have some.
  int descriptor() const { return socket_; }
  /// Why nothing more will come of it; empty: it runs.
  const std::string& ended() const { return ended_; }

 private:
  static constexpr std::size_t kMaxUnsent = 1 << 16;
  static constexpr std::size_t kMaxReceived = 1 << 22;
  CameraDriver(pid_t child, int socket, std::string name)
      : child_(child), socket_(socket), name_(std::move(name)) {}
  void flush();
  void receive();
  void end_by_itself();
  void end(const std::string& why);

  pid_t child_;  ///< -1: it has ended
  int socket_;   ///< to both its standard input and output
  std::string name_;
  std::string received_, unsent_;
  std::string ended_;
};

}  // namespace strobe::tether
