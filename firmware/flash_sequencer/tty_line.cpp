#include "firmware/flash_sequencer/tty_line.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "firmware/linux/rig_lines.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

/// Empty, or why it could not be.
std::string make_raw(int fd) {
  termios settings{};
  if (tcgetattr(fd, &settings) != 0) return errno == ENOTTY ? "is no serial port" : std::strerror(errno);
  cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARENB | CRTSCTS);
  settings.c_cflag |= CS8 | CREAD | CLOCAL;
  settings.c_iflag &= ~static_cast<tcflag_t>(IXON | IXOFF | IXANY);
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  cfsetispeed(&settings, B1000000);
  cfsetospeed(&settings, B1000000);
  const bool set = tcsetattr(fd, TCSANOW, &settings) == 0 && tcgetattr(fd, &settings) == 0;
  if (!set || cfgetospeed(&settings) != B1000000) return "cannot be set to 1000000 baud";
  return {};
}

/// Adapters on USB collect bytes for up to 16 ms otherwise. Most drivers know no such setting.
void ask_for_low_latency(int fd) {
  serial_struct serial{};
  if (ioctl(fd, TIOCGSERIAL, &serial) != 0) return;
  serial.flags |= ASYNC_LOW_LATENCY;
  ioctl(fd, TIOCSSERIAL, &serial);
}

}  // namespace

Result<std::unique_ptr<TtyLine>> TtyLine::open(const Rig& rig) {
  const std::string& port = rig.flash_sequencer.port;
  const auto failed = [&](const std::string& what) {
    return fail(place(rig, rig.flash_sequencer.port_file_line, "sequencer.port") + "\"" + port + "\" " +
                what);
  };
  const int fd = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return failed(std::string("cannot be opened: ") + std::strerror(errno));
  std::unique_ptr<TtyLine> line(new TtyLine(fd));
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) return failed("is in use by another program");
  if (const std::string why = make_raw(fd); !why.empty()) return failed(why);
  ask_for_low_latency(fd);
  tcflush(fd, TCIOFLUSH);
  return line;
}

TtyLine::~TtyLine() { release(); }

void TtyLine::release() noexcept {
  if (const int fd = fd_.exchange(-1); fd >= 0) close(fd);
}

bool TtyLine::write(std::span<const std::uint8_t> bytes) noexcept {
  // The kernel refuses one of two that write at once: the other is done within microseconds.
  constexpr int kTries = 1000;
  for (int tries = 0; tries < kTries; ++tries) {
    const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
    if (written >= 0) return static_cast<std::size_t>(written) == bytes.size();
    if (errno != EAGAIN && errno != EINTR) return false;
  }
  return false;
}

std::optional<SerialLine::Departure> TtyLine::departure(std::int64_t bytes, MonoTime before,
                                                        MonoTime after) noexcept {
  // A port that is busy for longer has bytes of others.
  constexpr Duration kLongest = microseconds(50);
  SystemClock clock;
  MonoTime busy = kNoTime;
  for (MonoTime now = after; now < before + bytes * kByteTime + kLongest;) {
    const MonoTime asked = now;
    unsigned state = 0;
    if (ioctl(fd_, TIOCSERGETLSR, &state) != 0) return std::nullopt;
    now = clock.now();
    if ((state & TIOCSER_TEMT) == 0) {
      busy = asked;
    } else {
      return known(busy) ? std::optional(Departure{busy, now}) : std::nullopt;  // empty before it was filled
    }
  }
  return std::nullopt;
}

std::optional<std::size_t> TtyLine::read(std::span<std::uint8_t> bytes) noexcept {
  const ssize_t count = ::read(fd_, bytes.data(), bytes.size());
  if (count > 0) return static_cast<std::size_t>(count);
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  return std::nullopt;  // no bytes and no error: it was unplugged
}

bool TtyLine::wait(MonoTime until) noexcept {
  const timespec timeout = time_left(until);
  pollfd polled[] = {{fd_, POLLIN, 0}, {wake_fd_, POLLIN, 0}};
  if (ppoll(polled, 2, &timeout, nullptr) <= 0) return false;
  std::uint64_t wakes = 0;
  if (polled[1].revents != 0 && ::read(wake_fd_, &wakes, sizeof wakes) < 0) wakes = 0;
  return true;
}

bool TtyLine::poll(MonoTime until) noexcept {
  SystemClock clock;
  bool ready = false;
  do ready = wait(MonoTime{});
  while (!ready && clock.now() < until);
  return ready;
}

}  // namespace strobe::firmware
