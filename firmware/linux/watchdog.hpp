// Tells from the marks that the worker's threads leave whether one of them hangs. Pure; one thread's.
//
// A machine, or one core of a virtual one, may stand still for longer than a hung loop can be left alone, and
// the clock goes on meanwhile. So time alone is given half a second. But a guardian that looks every 10 ms
// from the very core that the loop ran on, at a higher priority, and comes round in time each time, has seen
// that core run: a loop that does not turn in that time hangs.
#pragma once

#include "common/units/time.hpp"

namespace strobe::firmware {

/// When each last came round; 0: it does not run yet.
struct Heartbeats {
  MonoTime loop{};
  MonoTime publisher{};
};

class Watchdog {
 public:
  /// Whatever the guardian has seen of the core. A virtual machine may stand still for 200 ms.
  static constexpr Duration kLoopTimeout = milliseconds(500);
  /// The loop turns every 50 ms: from here on it is looked at closely.
  static constexpr Duration kLoopSuspectAfter = milliseconds(100);
  /// For so long its core must be seen to run, without a turn, from when it is suspect.
  static constexpr Duration kCoreSeenRunning = milliseconds(60);
  /// The publisher turns twice a second, but a slow disk may keep it for seconds.
  static constexpr Duration kPublisherTimeout = milliseconds(10'000);

  /// By time alone it is said so much after the limit: if the whole machine stood still, the worker is given
  /// its turn first.
  static constexpr Duration kTurn = milliseconds(100);

  explicit Watchdog(Duration publisher_hung = kPublisherTimeout) : publisher_timeout_(publisher_hung) {}

  /// What the publisher is granted under a service manager's watchdog: to be dealt with before the manager
  /// kills everything.
  static Duration publisher_timeout_for(Duration watchdog);

  enum class Verdict { well, loop_hung, publisher_hung };
  /// `on_loop_core`: since the look before, the guardian can only have run on the loop's core, and before the
  /// loop.
  Verdict look(const Heartbeats& marks, MonoTime now, bool on_loop_core = false);
  /// The guardian should go to the loop's core.
  bool suspect() const { return suspect_; }
  /// From the last look to the next: 10 to 100 ms.
  Duration until_next_look() const;

 private:
  static constexpr Duration kLook = milliseconds(100);
  static constexpr Duration kCloseLook = milliseconds(10);
  static constexpr Duration kInTime = milliseconds(15);  ///< between close looks

  void see_core(MonoTime loop, MonoTime now, bool in_time);

  Duration publisher_timeout_{};
  Duration loop_stale_{}, publisher_stale_{};  ///< past the limits, as far as it was looked at
  MonoTime loop_{}, looked_{};                 ///< at the last look
  bool suspect_ = false;
  Duration core_seen_running_{};  ///< the loop's core, since the loop is suspect
};

}  // namespace strobe::firmware
