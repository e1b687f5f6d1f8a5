#include "firmware/linux/console.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace strobe::firmware {

namespace {

constexpr std::chrono::milliseconds kLastWords{500};

/// An error other than a full pipe that does not block loses the rest: there is nobody to tell.
void write_all(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(fd, text.data(), text.size());
    if (n > 0) {
      text.remove_prefix(static_cast<std::size_t>(n));
    } else if (n < 0 && errno == EAGAIN) {
      pollfd writable{fd, POLLOUT, 0};
      poll(&writable, 1, -1);
    } else if (n == 0 || errno != EINTR) {
      return;
    }
  }
}

bool takes_a_line(int fd) {
  pollfd writable{fd, POLLOUT, 0};
  return poll(&writable, 1, 0) == 1;
}

std::string with_name(std::string_view line) {
  return std::string("strobed: ").append(line.substr(0, Console::kLongestLine)).append("\n");
}

std::string loss(std::int64_t lines) {
  return with_name(std::to_string(lines) + " lines are missing here: standard error was blocked");
}

}  // namespace

struct Console::State {
  explicit State(int out) : fd(out) {}
  const int fd;
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> lines;
  std::int64_t lost = 0;  ///< after the lines
  bool writing = false;
  bool over = false;

  bool idle() const { return lines.empty() && lost == 0 && !writing; }
  std::string take() {
    if (lines.empty()) return loss(std::exchange(lost, 0));
    std::string line = std::move(lines.front());
    lines.pop_front();
    return line;
  }
};

Console::Console(int fd) : state_(std::make_shared<State>(fd)) {
  try {
    std::thread(write_lines, state_).detach();
  } catch (const std::system_error&) {
    has_writer_ = false;
  }
}

Console::~Console() {
  std::unique_lock lock(state_->mutex);
  if (has_writer_) state_->changed.wait_for(lock, kLastWords, [this] { return state_->idle(); });
  state_->over = true;
  state_->changed.notify_all();
}

void Console::say(std::string_view line) noexcept {
  const std::lock_guard lock(state_->mutex);
  try {
    // Behind a loss only once there is room to tell of it.
    if (!has_writer_ && takes_a_line(state_->fd)) return write_all(state_->fd, with_name(line));
    const bool room = state_->lines.size() + (state_->lost > 0 ? 1 : 0) < kMaxLines;
    if (room && state_->lost > 0) state_->lines.push_back(loss(std::exchange(state_->lost, 0)));
    if (room) state_->lines.push_back(with_name(line));
    if (!room) ++state_->lost;
  } catch (const std::exception&) {
    ++state_->lost;
  }
  state_->changed.notify_all();
}

void Console::write_lines(const std::shared_ptr<State>& state) {
  std::unique_lock lock(state->mutex);
  for (;;) {
    state->changed.wait(lock, [&state] { return state->over || !state->lines.empty() || state->lost > 0; });
    if (state->over) return;
    const std::string line = state->take();
    state->writing = true;
    lock.unlock();
    write_all(state->fd, line);
    lock.lock();
    state->writing = false;
    state->changed.notify_all();
  }
}

}  // namespace strobe::firmware
