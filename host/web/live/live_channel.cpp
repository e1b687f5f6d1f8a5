#include "host/web/live/live_channel.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

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
  const std::lock_guard lock(messages_mutex_);
  ended_ = true;
  changed_.notify_one();
}

bool LiveChannel::command(LiveCommand command) {
  {
    const std::lock_guard lock(commands_mutex_);
    if (commands_.size() >= kMaxCommands) return false;
    commands_.push_back(std::move(command));
    has_commands_ = true;
  }
  const std::uint64_t one = 1;
  if (event_ >= 0) static_cast<void>(!write(event_, &one, sizeof one));
  return true;
}

std::vector<LiveCommand> LiveChannel::take_commands() {
  if (!has_commands_) return {};
  const std::unique_lock lock(commands_mutex_, std::try_to_lock);
  if (!lock) return {};
  std::uint64_t told = 0;
  if (event_ >= 0) static_cast<void>(!read(event_, &told, sizeof told));
  has_commands_ = false;
  return std::exchange(commands_, {});
}

}  // namespace strobe::web
