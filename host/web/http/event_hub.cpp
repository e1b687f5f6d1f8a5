#include "host/web/http/event_hub.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <chrono>
#include <utility>

namespace strobe::web {

void EventHub::publish(std::string_view event, std::string json) {
  std::ranges::replace_if(
      json, [](char c) { return c == '\n' || c == '\r'; }, ' ');
  {
    const std::lock_guard lock(mutex_);
    std::string text = fmt::format("id: {}\nevent: {}\ndata: {}\n\n", next_id_, event, json);
    ++next_id_;
    kept_bytes_ += text.size();
    kept_.push_back(std::move(text));
    while (kept_.size() > 1 && (kept_.size() > kMaxKept || kept_bytes_ > kMaxKept_bytes)) {
      kept_bytes_ -= kept_.front().size();
      kept_.pop_front();
      ++oldest_;
    }
    assert(next_id_ - oldest_ == static_cast<std::int64_t>(kept_.size()));
  }
  const std::lock_guard lock(wake_mutex_);
  if (wake_) wake_();
}

std::int64_t EventHub::last_id() const {
  const std::lock_guard lock(mutex_);
  return next_id_ - 1;
}

EventHub::Taken EventHub::take_after(std::int64_t seen, std::size_t max_bytes) const {
  const std::lock_guard lock(mutex_);
  const std::int64_t last = next_id_ - 1;
  if (seen == last) return {"", last};
  if (seen < oldest_ - 1 || seen > last)
    return {fmt::format("id: {}\nevent: reset\ndata: {{}}\n\n", last), last};
  Taken taken{"", seen};
  for (auto text = kept_.begin() + (seen + 1 - oldest_); text != kept_.end(); ++text) {
    if (!taken.text.empty() && taken.text.size() + text->size() > max_bytes) break;
    taken.text += *text;
    ++taken.last_id;
  }
  return taken;
}

void EventHub::set_wake(std::function<void()> wake) {
  const std::lock_guard lock(wake_mutex_);
  wake_ = std::move(wake);
}

std::int64_t first_event_id() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  // A number that JSON readers keep exactly, with room for 100 events a millisecond.
  return std::chrono::duration_cast<std::chrono::milliseconds>(now).count() * 100;
}

}  // namespace strobe::web
