#include "sim/flash_sequencer/terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

namespace strobe::sim::sequencer {
namespace {

namespace fs = std::filesystem;
using MachineClock = std::chrono::steady_clock;

// The kernel hands bytes over by a thread of its own, which rig time would overtake if this one slept.
constexpr std::chrono::milliseconds kLongestHandover{100};

int waiting_bytes(int terminal) {
  int count = 0;
  return ::ioctl(terminal, FIONREAD, &count) == 0 ? count : 0;
}

}  // namespace

Result<Terminal> Terminal::open(const fs::path& path, Chip& chip) {
  Terminal terminal(chip, path);
  if (const auto made = terminal.make(); !made) return tl::unexpected(made.error());
  return terminal;
}

Result<void> Terminal::make() {
  const auto failed = [this](const char* what) {
    return fail(path_.string() + ": " + what + ": " + std::strerror(errno));
  };
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  char name[128];
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
      ::ptsname_r(master_, name, sizeof name) != 0 || ::fcntl(master_, F_SETFL, O_NONBLOCK) != 0)
    return failed("no pseudo terminal");
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  if (slave_ < 0 || ::tcgetattr(slave_, &settings) != 0) return failed("the pseudo terminal");
  ::cfmakeraw(&settings);
  if (::tcsetattr(slave_, TCSANOW, &settings) != 0) return failed("the pseudo terminal");
  std::error_code error;
  fs::remove(path_, error);
  fs::create_symlink(name, path_, error);
  if (error) return fail(path_.string() + ": " + error.message());
  chip_.await_writes_to(slave_);
  return {};
}

Terminal::Terminal(Terminal&& other) noexcept
    : chip_(other.chip_),
      path_(std::exchange(other.path_, {})),
      master_(std::exchange(other.master_, -1)),
      slave_(std::exchange(other.slave_, -1)) {}

Terminal::~Terminal() {
  if (slave_ >= 0) ::close(slave_);
  if (master_ >= 0) ::close(master_);
  std::error_code error;
  if (!path_.empty()) fs::remove(path_, error);
}

std::size_t Terminal::read(std::span<std::uint8_t> bytes) {
  const ssize_t count = ::read(master_, bytes.data(), bytes.size());
  if (count <= 0) return 0;
  chip_.took_written(static_cast<std::size_t>(count));
  return static_cast<std::size_t>(count);
}

MonoTime Terminal::written(MonoTime now) const { return std::min(now, chip_.last_written().value_or(now)); }

void Terminal::write(std::span<const std::uint8_t> bytes) {
  const int before = waiting_bytes(slave_);
  if (::write(master_, bytes.data(), bytes.size()) <= 0 || !chip_.last_written()) return;
  const auto latest = MachineClock::now() + kLongestHandover;
  while (waiting_bytes(slave_) == before && MachineClock::now() < latest) std::this_thread::yield();
}

}  // namespace strobe::sim::sequencer
