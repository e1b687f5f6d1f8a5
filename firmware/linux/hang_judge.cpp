#include "firmware/linux/hang_judge.hpp"

#include <algorithm>

namespace strobe::firmware {

namespace {

bool stale(MonoTime mark, MonoTime now, Duration limit) { return mark.ns != 0 && now - mark > limit; }

}  // namespace

Duration HangJudge::publisher_limit(Duration watchdog) {
  return watchdog.ns > 0 ? std::min(kPublisherHangs, nanoseconds(watchdog.ns / 2)) : kPublisherHangs;
}

/// Time counts only between looks that came in time: in any other the core may have stood still.
void HangJudge::see_core(MonoTime loop, MonoTime now, bool in_time) {
  const bool turned = loop != loop_;
  doubtful_ = stale(loop, now, kLoopDoubtful);
  seen_to_run_ = doubtful_ && in_time && !turned ? seen_to_run_ + (now - looked_) : Duration{0};
  loop_ = loop;
  looked_ = now;
}

HangJudge::Verdict HangJudge::look(const WorkerMarks& marks, MonoTime now, bool beside_loop) {
  const Duration passed = looked_.ns == 0 ? Duration{0} : now - looked_;
  see_core(marks.loop, now, beside_loop && passed <= kInTime);
  // A longer time between two looks may have been a standstill of the machine, and counts as little.
  const Duration counted = std::min(passed, kInTime);
  const bool loop = stale(marks.loop, now, kLoopHangs);
  loop_stale_ = loop ? loop_stale_ + counted : Duration{0};
  const bool publisher = stale(marks.publisher, now, publisher_hangs_);
  publisher_stale_ = publisher ? publisher_stale_ + counted : Duration{0};
  if (loop_stale_ >= kTurn || seen_to_run_ >= kSeenToRun) return Verdict::loop_hangs;
  if (publisher_stale_ >= kTurn) return Verdict::publisher_hangs;
  return Verdict::well;
}

Duration HangJudge::until_next_look() const {
  if (loop_.ns == 0) return kLook;
  return std::clamp(loop_ + kLoopDoubtful + milliseconds(1) - looked_, kCloseLook, kLook);
}

}  // namespace strobe::firmware
