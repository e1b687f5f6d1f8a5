#include "sim/flash_sequencer/terminal.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "sim/gpiochip/state.hpp"

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
  const fs::path fifo = chip_.dir() / gpio::kTerminalFile;
  // Programs may run as another user than the rig.
  if (::mkfifo(fifo.c_str(), 0666) != 0 || ::chmod(fifo.c_str(), 0666) != 0) return failed("no FIFO");
  written_ = ::open(fifo.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (written_ < 0) return failed("no FIFO");
  fs::create_symlink(name, path_, error);
  if (error) return fail(path_.string() + ": " + error.message());
  chip_.await_writes_to(slave_);
  return {};
}

Terminal::Terminal(Terminal&& other) noexcept
    : chip_(other.chip_),
      path_(std::exchange(other.path_, {})),
      written_(std::exchange(other.written_, -1)),
      master_(std::exchange(other.master_, -1)),
      slave_(std::exchange(other.slave_, -1)) {}

Terminal::~Terminal() {
  if (slave_ >= 0) ::close(slave_);
  if (master_ >= 0) ::close(master_);
  std::error_code error;
  if (written_ >= 0) fs::remove(chip_.dir() / gpio::kTerminalFile, error);
  if (written_ >= 0) ::close(written_);
  if (!path_.empty()) fs::remove(path_, error);
}

std::optional<Terminal::Written> Terminal::read() {
  gpio::TerminalWrite head{};
  if (::read(written_, &head, sizeof head) != static_cast<ssize_t>(sizeof head)) return std::nullopt;
  std::vector<std::uint8_t> bytes(std::min<std::size_t>(head.size, gpio::TerminalWrite::kMaxSize));
  if (::read(written_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size())) return std::nullopt;
  chip_.took_written(bytes.size());
  return Written{from_ns(head.at_ns), std::move(bytes)};
}

void Terminal::write(std::span<const std::uint8_t> bytes) {
  const int before = waiting_bytes(slave_);
  if (::write(master_, bytes.data(), bytes.size()) <= 0 || !chip_.keeps_time()) return;
  const auto latest = MachineClock::now() + kLongestHandover;
  while (waiting_bytes(slave_) == before && MachineClock::now() < latest) std::this_thread::yield();
}

}  // namespace strobe::sim::sequencer
