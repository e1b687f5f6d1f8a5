// Decides from the heartbeats of the worker's threads whether one of them hangs. Pure; one thread's.
//
// A virtual machine, or one of its cores, may stand still for longer than a hung loop can be tolerated, while
// the clock goes on. So by time alone a loop hangs after half a second. But a guardian that checks every
// 10 ms on the loop's own core, at a higher priority and each time punctually, has seen that core run: a loop
// without a heartbeat in that time hangs. Or so it is taken: a loop that waits in the kernel for a page from
// a disk or for a bus that is stalled looks the same, as does one that a busy machine starves. While a shot
// is under way that is the safe side. While none is, nothing is active that a loop could leave on, and it is
// waited for.
#pragma once

#include "common/units/time.hpp"

namespace strobe::firmware {

/// When each thread last ran; 0 if it does not run yet.
struct Heartbeats {
  MonoTime loop{};
  MonoTime publisher{};
  bool shot_under_way = true;  ///< outputs may be active
};

class Watchdog {
 public:
  /// By time alone; a virtual machine may stand still for 200 ms.
  static constexpr Duration kLoopTimeout = milliseconds(500);
  /// The loop runs every 50 ms: a heartbeat older than this is checked closely.
  static constexpr Duration kLoopSuspectAfter = milliseconds(100);
  /// The loop hangs if its core was seen to run for so long while the loop is suspect.
  static constexpr Duration kCoreSeenRunning = milliseconds(60);
  /// The publisher runs twice a second, but a slow disk may block it for seconds.
  static constexpr Duration kPublisherTimeout = milliseconds(10'000);

  /// Time after a timeout before it counts: if the whole machine stood still, the worker runs first.
  static constexpr Duration kGrace = milliseconds(100);

  explicit Watchdog(Duration publisher_hung = kPublisherTimeout) : publisher_timeout_(publisher_hung) {}

  /// The publisher's timeout under a service manager's watchdog (0: none): soon enough to act before the
  /// manager kills everything.
  static Duration publisher_timeout_for(Duration watchdog);

  /// loop_stands_still: as loop_hung, but no shot is under way.
  enum class Verdict { healthy, loop_hung, loop_stands_still, publisher_hung };
  /// on_loop_core: since the last check the caller has run on the loop's core only, at a higher priority.
  Verdict check(const Heartbeats& marks, MonoTime now, bool on_loop_core = false);
  /// The guardian should move to the loop's core.
  bool suspect() const { return suspect_; }
  /// Time from the last check to the next: 10 to 100 ms.
  Duration until_next_check() const;

 private:
  static constexpr Duration kCheckInterval = milliseconds(100);
  static constexpr Duration kCloseCheckInterval = milliseconds(10);
  static constexpr Duration kInTime = milliseconds(15);  ///< between close checks

  void see_core(MonoTime loop, MonoTime now, bool in_time);

  Duration publisher_timeout_{};
  Duration loop_stale_{}, publisher_stale_{};  ///< observed time past the timeouts
  MonoTime loop_{}, last_check_{};             ///< at the last check
  bool suspect_ = false;
  Duration core_seen_running_{};  ///< since the loop is suspect
};

}  // namespace strobe::firmware
