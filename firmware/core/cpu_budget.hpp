// How long the loop may sleep before a pulse. A core that is held by work inside the kernel wakes nobody for
// up to some milliseconds, but it does not put to sleep who is awake: so the loop is awake well before every
// pulse. Not for ever: a real-time thread that hardly sleeps is stopped by the kernel for 50 ms in every
// second (sched_rt_runtime_us). So its time awake in the last second is counted and bounded.
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
  /// Of the slots of the last second; a second that begins within a slot holds at most one slot more.
  static constexpr Duration kMax = milliseconds(880);
  static constexpr double kMaxShare = to_seconds(kMax + kSlot);

  explicit CpuBudget(const Rig::Tolerance& tolerance) noexcept
      : spin_(tolerance.spin), ahead_(std::max(tolerance.spin, tolerance.wake_ahead)) {}

  /// The last instant for which the loop may sleep before a pulse at `due`.
  MonoTime wake_time(MonoTime due) const noexcept { return due - (sum_ < kMax ? ahead_ : spin_); }

  /// The loop has been awake for so long up to now.
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
