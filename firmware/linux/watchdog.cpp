#include "firmware/linux/watchdog.hpp"

#include <algorithm>

namespace strobe::firmware {

namespace {

bool stale(MonoTime mark, MonoTime now, Duration limit) { return mark != MonoTime{} && now - mark > limit; }

}  // namespace

Duration Watchdog::publisher_timeout_for(Duration watchdog) {
  return watchdog > Duration{} ? std::min(kPublisherTimeout, watchdog / 2) : kPublisherTimeout;
}

/// Time counts only between looks that came in time: in any other the core may have stood still.
void Watchdog::see_core(MonoTime loop, MonoTime now, bool in_time) {
  const bool turned = loop != loop_;
  suspect_ = stale(loop, now, kLoopSuspectAfter);
  core_seen_running_ = suspect_ && in_time && !turned ? core_seen_running_ + (now - last_check_) : Duration{};
  loop_ = loop;
  last_check_ = now;
}

Watchdog::Verdict Watchdog::check(const Heartbeats& marks, MonoTime now, bool on_loop_core) {
  const Duration passed = last_check_ == MonoTime{} ? Duration{} : now - last_check_;
  see_core(marks.loop, now, on_loop_core && passed <= kInTime);
  // A longer time between two looks may have been a standstill of the machine, and counts as little.
  const Duration counted = std::min(passed, kInTime);
  const bool loop = stale(marks.loop, now, kLoopTimeout);
  loop_stale_ = loop ? loop_stale_ + counted : Duration{};
  const bool publisher = stale(marks.publisher, now, publisher_timeout_);
  publisher_stale_ = publisher ? publisher_stale_ + counted : Duration{};
  if (loop_stale_ >= kGrace || core_seen_running_ >= kCoreSeenRunning)
    return marks.shot_under_way ? Verdict::loop_hung : Verdict::loop_stands_still;
  if (publisher_stale_ >= kGrace) return Verdict::publisher_hung;
  return Verdict::healthy;
}

Duration Watchdog::until_next_check() const {
  if (loop_ == MonoTime{}) return kCheckInterval;
  return std::clamp(loop_ + kLoopSuspectAfter + milliseconds(1) - last_check_, kCloseCheckInterval,
                    kCheckInterval);
}

}  // namespace strobe::firmware
