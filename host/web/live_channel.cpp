#include "host/web/live_channel.hpp"

#include <sys/eventfd.h>
#include <unistd.h>
#include <cassert>
#include <cstdint>
#include <utility>

namespace strobe::web {

LiveChannel::LiveChannel() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

LiveChannel::~LiveChannel() {
  if (event_ >= 0) close(event_);
}

void LiveChannel::put(std::deque<LiveMessage>& messages) {
  if (messages.empty()) return;
  const std::unique_lock lock(messages_mutex_, std::try_to_lock);
  if (!lock) return;
  while (!messages.empty() && messages_.size() < kMaxMessages) {
    messages_.push_back(std::move(messages.front()));
    messages.pop_front();
  }
  changed_.notify_one();
}

LiveChannel::Taken LiveChannel::take() {
  std::unique_lock lock(messages_mutex_);
  changed_.wait(lock, [this] { return ended_ || !messages_.empty(); });
  return {std::exchange(messages_, {}), ended_};
}

void LiveChannel::end() {
  {
    const std::lock_guard lock(messages_mutex_);
    ended_ = true;
    changed_.notify_one();
  }
  const std::lock_guard lock(commands_mutex_);
  nobody_takes_ = true;
  commands_taken_.notify_all();
}

LiveChannel::Given LiveChannel::command(LiveCommand command, std::chrono::milliseconds patience) {
  std::unique_lock lock(commands_mutex_);
  if (commands_.size() >= kMaxCommands) return Given::too_many;
  if (commands_.empty()) oldest_ = std::chrono::steady_clock::now();
  const auto deadline = oldest_ + patience;
  commands_.push_back(std::move(command));
  const std::int64_t own = ++given_;
  has_commands_ = true;
  const std::uint64_t one = 1;
  if (event_ >= 0) static_cast<void>(!write(event_, &one, sizeof one));
  commands_taken_.wait_until(lock, deadline, [&] { return taken_ >= own || nobody_takes_; });
  return taken_ >= own ? Given::taken : Given::waits;
}

std::vector<LiveCommand> LiveChannel::take_commands() {
  if (!has_commands_) return {};
  const std::unique_lock lock(commands_mutex_, std::try_to_lock);
  if (!lock) return {};
  std::uint64_t told = 0;
  if (event_ >= 0) static_cast<void>(!read(event_, &told, sizeof told));
  has_commands_ = false;
  taken_ = given_;
  assert(commands_.size() <= kMaxCommands);
  commands_taken_.notify_all();
  return std::exchange(commands_, {});
}

}  // namespace strobe::web
