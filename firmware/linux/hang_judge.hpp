// Tells from the marks that the worker's threads leave whether one of them hangs. Pure; one thread's.
#pragma once

#include "common/units/time.hpp"

namespace strobe::firmware {

/// When each last came round; 0: it does not run yet.
struct WorkerMarks {
  MonoTime loop{0};
  MonoTime publisher{0};
};

class HangJudge {
 public:
  /// The loop turns every 50 ms; a virtual machine may stand still for 200 ms.
  static constexpr Duration kLoopHangs = milliseconds(500);
  /// The publisher turns twice a second, but a slow disk may keep it for seconds.
  static constexpr Duration kPublisherHangs = milliseconds(10'000);

  explicit HangJudge(Duration publisher_hangs = kPublisherHangs) : publisher_hangs_(publisher_hangs) {}

  /// What the publisher is granted under a service manager's watchdog: to be dealt with before the manager
  /// kills everything.
  static Duration publisher_limit(Duration watchdog);

  enum class Verdict { well, loop_hangs, publisher_hangs };
  /// To be called every 100 ms or so. Twice in a row before it is said: if the whole machine stood still, the
  /// worker is given its turn first.
  Verdict look(const WorkerMarks& marks, MonoTime now);

 private:
  Duration publisher_hangs_;
  int loop_stale_ = 0;
  int publisher_stale_ = 0;
};

}  // namespace strobe::firmware
