#include "firmware/flash_sequencer/tty_line.hpp"

#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include "firmware/flash_sequencer/heartbeat.hpp"
#include "firmware/linux/event_fd.hpp"
#include "firmware/linux/system_clock.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr Duration kLong = milliseconds(60'000);  // for what comes at once

/// The other end of a pseudo terminal.
struct OtherEnd {
  int fd = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  std::string path;
  OtherEnd() {
    CHECK(fd >= 0 && grantpt(fd) == 0 && unlockpt(fd) == 0);
    path = ptsname(fd);
  }
  OtherEnd(const OtherEnd&) = delete;
  OtherEnd& operator=(const OtherEnd&) = delete;
  ~OtherEnd() { close(fd); }
  /// What comes within so long, as many bytes as that.
  std::string take(std::size_t size, int timeout_ms) {
    std::string taken(size, '\0');
    std::size_t count = 0;
    pollfd polled{fd, POLLIN, 0};
    while (count < size && ::poll(&polled, 1, timeout_ms) > 0) {
      const ssize_t got = read(fd, taken.data() + count, size - count);
      if (got <= 0) break;
      count += static_cast<std::size_t>(got);
    }
    taken.resize(count);
    return taken;
  }
};

Rig rig_on(const std::string& port) {
  Rig rig;
  rig.file_name = "rig.toml";
  rig.flash_sequencer = {port, 12};
  return rig;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

TEST_GROUP(TtyLine) {
  OtherEnd other;
  SystemClock clock;
  std::string error_of(const std::string& port) { return TtyLine::open(rig_on(port)).error().message; }
  std::unique_ptr<TtyLine> open() {
    auto line = TtyLine::open(rig_on(other.path));
    CHECK_TRUE_TEXT(line.has_value(), line ? "" : line.error().message.c_str());
    return std::move(*line);
  }
};

TEST(TtyLine, NamesTheRigFilesLineWhenItCannotBeOpened) {
  CHECK_EQUAL(std::string("rig.toml:12: sequencer.port: \"/nonexistent\" cannot be opened: No such file or directory"),
              error_of("/nonexistent"));
  const testing::TemporaryFolder folder;
  const std::string file = folder.path() / "file";
  std::ofstream(file) << "text";
  CHECK_EQUAL("rig.toml:12: sequencer.port: \"" + file + "\" is no serial port", error_of(file));
}

TEST(TtyLine, IsOneProgramsAtATime) {
  auto line = open();
  CHECK_EQUAL("rig.toml:12: sequencer.port: \"" + other.path + "\" is in use by another program", error_of(other.path));
  line.reset();
  open();
}

TEST(TtyLine, CarriesEveryByteAsItIs) {
  const auto line = open();
  std::string all;
  for (int value = 0; value < 256; ++value) all += static_cast<char>(value);
  CHECK(line->write(bytes_of(all)));
  CHECK(all == other.take(all.size(), 60'000));
  CHECK_EQUAL(static_cast<ssize_t>(all.size()), write(other.fd, all.data(), all.size()));
  std::string taken;
  while (taken.size() < all.size()) {
    CHECK(line->wait(clock.now() + kLong));
    std::array<std::uint8_t, 100> bytes;
    const auto count = line->read(bytes);
    CHECK(count.has_value());
    taken.append(reinterpret_cast<const char*>(bytes.data()), *count);
  }
  CHECK(all == taken);
}

TEST(TtyLine, DoesNotWaitToRead) {
  const auto line = open();
  std::array<std::uint8_t, 10> bytes;
  CHECK_EQUAL(0u, line->read(bytes).value());
  CHECK_FALSE(line->wait(clock.now() + milliseconds(1)));
  CHECK_FALSE(line->poll(clock.now() + milliseconds(1)));
}

TEST(TtyLine, WakesWhoeverWaits) {
  const auto line = open();
  EventFd wake;
  line->set_wake(wake.fd());
  wake.wake();
  CHECK(line->wait(clock.now() + kLong));
  CHECK_EQUAL(0u, wake.take());
}

TEST(TtyLine, SaysThatItIsGone) {
  auto gone = std::make_unique<OtherEnd>();
  const auto line = TtyLine::open(rig_on(gone->path)).value().release();
  gone.reset();
  std::array<std::uint8_t, 10> bytes;
  CHECK(line->wait(clock.now() + kLong));
  CHECK_FALSE(line->read(bytes).has_value());
  CHECK_FALSE(line->write(bytes_of("x")));
  delete line;
}

TEST(TtyLine, IsNoLongerHeldOnceReleased) {
  const auto line = open();
  line->release();
  CHECK_FALSE(line->write(bytes_of("x")));
  open();
}

TEST(TtyLine, SaysThatItIsFullRatherThanWait) {
  const auto line = open();
  const std::string much(4096, 'x');
  int written = 0;
  while (written < 1000 && line->write(bytes_of(much))) ++written;
  CHECK(written < 1000);
}

TEST(TtyLine, HasBeatsForAsLongAsTheLoopTurns) {
  const auto line = open();
  Heartbeat heartbeat(*line, clock);
  std::atomic<std::int64_t> turned_ns{to_ns(clock.now() - Heartbeat::kLoopHangs - milliseconds(1))};
  heartbeat.start(turned_ns, 0, -1);
  CHECK_EQUAL(std::string(), other.take(1, 60));  // beats of fifteen
  flash_sequencer::Decoder decoder;
  int beats = 0;
  while (beats < 3) {
    turned_ns = to_ns(clock.now());
    for (const char byte : other.take(1, 60'000)) {
      const auto* frame = decoder.take(static_cast<std::uint8_t>(byte));
      if (frame == nullptr) continue;
      CHECK_EQUAL(static_cast<int>(flash_sequencer::Request::beat), static_cast<int>(frame->kind));
      CHECK_EQUAL(Heartbeat::kFirstNumber + beats, static_cast<int>(frame->number));
      const auto left = heartbeat.departure(frame->number);
      CHECK(left.has_value() && left->not_before <= left->not_after);
      ++beats;
    }
  }
  CHECK_EQUAL(0u, decoder.damaged());
  heartbeat.stop();
}
