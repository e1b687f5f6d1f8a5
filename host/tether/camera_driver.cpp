#include "host/tether/camera_driver.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/external/program.hpp"

namespace strobe::tether {
namespace {

constexpr int kEndWithin_ms = 1000;

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return fmt::format("it was ended by {}", strsignal(WTERMSIG(status)));
  return fmt::format("it ended with status {}", WEXITSTATUS(status));
}

/// As a child of this process's own group: a Ctrl-C at the terminal is for strobe, which still wants the
/// photograph of the shot under way.
pid_t spawn_driver(const std::filesystem::path& program, int descriptor) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, descriptor, 0);
  posix_spawn_file_actions_adddup2(&actions, descriptor, 1);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string path = program.string();
  std::array<char*, 2> words{path.data(), nullptr};
  pid_t child = -1;
  if (posix_spawn(&child, path.c_str(), &actions, &attributes, words.data(), environ) != 0) child = -1;
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return child;
}

}  // namespace

Result<std::filesystem::path> CameraDriver::find(const std::string& kind) {
  const std::string name = "strobe-camera-" + kind;
  if (const auto program = external::find_own_program(name)) return *program;
  return fail(fmt::format("{} is not installed: it is in the package strobe-camera, and is built where {} is",
                          name, kind == "genicam" ? "libaravis-dev" : "libgphoto2-dev"));
}

Result<std::unique_ptr<CameraDriver>> CameraDriver::start(const std::filesystem::path& program) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    return fail(program.string() + ": no socket: " + std::strerror(errno));
  const pid_t child = spawn_driver(program, ends[1]);
  close(ends[1]);
  if (child < 0) {
    close(ends[0]);
    return fail(program.string() + ": cannot be started");
  }
  fcntl(ends[0], F_SETFL, O_NONBLOCK);
  return std::unique_ptr<CameraDriver>(new CameraDriver(child, ends[0], program.filename().string()));
}

CameraDriver::~CameraDriver() {
  shutdown(socket_, SHUT_WR);
  pollfd its_end{socket_, POLLIN, 0};
  std::array<char, 4096> rest{};
  while (child_ > 0 && poll(&its_end, 1, kEndWithin_ms) > 0) {
    if (read(socket_, rest.data(), rest.size()) <= 0) break;
  }
  end("");
  close(socket_);
}

void CameraDriver::end(const std::string& why) {
  if (child_ <= 0) return;
  int status = 0;
  kill(-child_, SIGKILL);  // with whatever it has started
  waitpid(std::exchange(child_, -1), &status, 0);
  ended_ = fmt::format("{}: {}", name_, why.empty() ? how_it_ended(status) : why);
}

void CameraDriver::send(const Request& request) {
  unsent_ += to_line(request) + "\n";
  flush();
}

void CameraDriver::flush() {
  while (!unsent_.empty() && child_ > 0) {
    const ssize_t n = ::send(socket_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL);
    if (n > 0) {
      unsent_.erase(0, static_cast<std::size_t>(n));
    } else if (errno != EINTR) {
      break;  // it does not read: tried again
    }
  }
  if (unsent_.size() > kMaxUnsent) end("it takes no requests");
}

void CameraDriver::receive() {
  std::array<char, 65536> buffer{};
  while (child_ > 0) {
    const ssize_t n = read(socket_, buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return;
    if (n <= 0) return end_by_itself();
    received_.append(buffer.data(), static_cast<std::size_t>(n));
    if (received_.size() > kMaxReceived) return end("it says too much at once");
  }
}

/// Its output is closed: it has ended, or is about to.
void CameraDriver::end_by_itself() {
  int status = 0;
  for (int i = 0; i < 100 && child_ > 0; ++i) {
    if (waitpid(child_, &status, WNOHANG) == child_) {
      child_ = -1;
      ended_ = fmt::format("{}: {}", name_, how_it_ended(status));
      return;
    }
    poll(nullptr, 0, 1);
  }
  end("it has closed its output");
}

std::vector<Event> CameraDriver::take_events() {
  flush();
  receive();
  std::vector<Event> events;
  std::size_t begin = 0;
  for (std::size_t end_of_line = received_.find('\n'); end_of_line != std::string::npos;
       end_of_line = received_.find('\n', begin)) {
    auto event = parse_event(std::string_view(received_).substr(begin, end_of_line - begin));
    begin = end_of_line + 1;
    if (event) {
      events.push_back(std::move(*event));
    } else {
      end("it said what is no event: " + event.error().message);
    }
  }
  received_.erase(0, begin);
  return events;
}

}  // namespace strobe::tether
