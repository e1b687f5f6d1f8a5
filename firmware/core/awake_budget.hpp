// How long the loop may sleep before a pulse. A core that is held by work inside the kernel wakes nobody for
// up to a millisecond, but it does not put to sleep who is awake: so the loop is awake well before every
// pulse. Not for ever: a real-time thread that never sleeps is stopped by the kernel for 50 ms in every
// second (sched_rt_runtime_us). A budget, filled by sleeping, bounds the time awake.
#pragma once

#include <algorithm>

#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// Real-time safe, one thread's.
class AwakeBudget {
 public:
  static constexpr Duration kMost = milliseconds(300);
  /// Time awake that a time asleep pays for. Of any second at most (kMost + 3 s) / 4 = 825 ms are awake.
  static constexpr int kPerSleep = 3;
  static constexpr double kLargestShare = 0.825;

  explicit AwakeBudget(const Rig::Tolerance& tolerance) noexcept
      : spin_(tolerance.spin), ahead_(std::max(tolerance.spin, tolerance.wake_ahead)) {}

  /// The last instant for which the loop may sleep before a pulse at `due`.
  MonoTime wake_for(MonoTime due) const noexcept { return due - (left_.ns > 0 ? ahead_ : spin_); }

  void was_awake(Duration time) noexcept { left_ = std::max(left_ - time, Duration{0}); }
  void was_asleep(Duration time) noexcept { left_ = std::min(left_ + time * kPerSleep, kMost); }

 private:
  Duration spin_;
  Duration ahead_;
  Duration left_ = kMost;
};

}  // namespace strobe::firmware
