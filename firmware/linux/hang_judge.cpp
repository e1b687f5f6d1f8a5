#include "firmware/linux/hang_judge.hpp"

#include <algorithm>

namespace strobe::firmware {

namespace {

bool stale(MonoTime mark, MonoTime now, Duration limit) { return mark.ns != 0 && now - mark > limit; }

}  // namespace

Duration HangJudge::publisher_limit(Duration watchdog) {
  return watchdog.ns > 0 ? std::min(kPublisherHangs, nanoseconds(watchdog.ns / 2)) : kPublisherHangs;
}

HangJudge::Verdict HangJudge::look(const WorkerMarks& marks, MonoTime now) {
  loop_stale_ = stale(marks.loop, now, kLoopHangs) ? loop_stale_ + 1 : 0;
  publisher_stale_ = stale(marks.publisher, now, publisher_hangs_) ? publisher_stale_ + 1 : 0;
  if (loop_stale_ >= 2) return Verdict::loop_hangs;
  if (publisher_stale_ >= 2) return Verdict::publisher_hangs;
  return Verdict::well;
}

}  // namespace strobe::firmware
