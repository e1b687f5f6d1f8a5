// How long the loop may sleep before a pulse. Work inside the kernel can delay a wake-up on its core by some
// milliseconds, but does not interrupt a thread that is already running: so the loop wakes well before every
// pulse. Its run time must stay bounded, as the kernel throttles a real-time thread that hardly sleeps for
// 50 ms in every second (sched_rt_runtime_us): the run time of the last second is counted.
#pragma once

#include <algorithm>
#include <array>

#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// Real-time safe, one thread's.
class CpuBudget {
 public:
  static constexpr Duration kSlot = milliseconds(50);
  static constexpr std::size_t kSlots = 20;
  /// Run time allowed in the slots of the last second; a second that begins within a slot has one slot more.
  static constexpr Duration kMax = milliseconds(880);
  static constexpr double kMaxShare = to_seconds(kMax + kSlot);

  explicit CpuBudget(const Rig::Tolerance& tolerance) noexcept
      : spin_(tolerance.spin), ahead_(std::max(tolerance.spin, tolerance.wake_ahead)) {}

  /// Until when the loop may sleep before a pulse at `due`.
  MonoTime wake_time(MonoTime due) const noexcept { return due - (sum_ < kMax ? ahead_ : spin_); }

  /// The loop ran for `awake` up to now.
  void note(MonoTime now, Duration awake) noexcept {
    for (std::size_t passed = 0; slot_end_ <= now; ++passed) {
      if (passed == kSlots) {
        slot_end_ = now + kSlot;
        break;
      }
      slot_end_ = slot_end_ + kSlot;
      newest_ = (newest_ + 1) % kSlots;
      sum_ = sum_ - slots_[newest_];
      slots_[newest_] = {};
    }
    slots_[newest_] = slots_[newest_] + awake;
    sum_ = sum_ + awake;
  }

 private:
  Duration spin_{};
  Duration ahead_{};
  std::array<Duration, kSlots> slots_{};
  std::size_t newest_ = 0;
  MonoTime slot_end_{};
  Duration sum_{};
};

}  // namespace strobe::firmware
