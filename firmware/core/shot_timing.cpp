#include "firmware/core/shot_timing.hpp"

namespace strobe::firmware {

void ShotTiming::issued(MonoTime commanded, MonoTime start, MonoTime end) noexcept {
  add(TimingQuantity::lateness, start - commanded);
  add(TimingQuantity::issue, end - start);
}

void ShotTiming::seen(const ShotRecord& shot) noexcept {
  const FlashRecord* before = nullptr;
  for (const FlashRecord& flash : shot.flashes) {
    // A sensor may see the other lamp as well: that tells nothing of its own.
    const bool a = known(flash.observed_a) && has_a(flash.lamps);
    const bool b = known(flash.observed_b) && has_b(flash.lamps);
    if (a && b) add(TimingQuantity::skew, flash.observed_a - flash.observed_b);
    if (a && known(flash.issue_end)) add(TimingQuantity::lamp_delay_a, flash.observed_a - flash.issue_end);
    if (b && known(flash.issue_end)) add(TimingQuantity::lamp_delay_b, flash.observed_b - flash.issue_end);
    if (before != nullptr) add_interval(*before, flash);
    before = &flash;
  }
}

/// Of one sensor each, so that what differs between the sensors is not taken for an error of the period.
void ShotTiming::add_interval(const FlashRecord& before, const FlashRecord& flash) noexcept {
  std::int64_t sum_ns = 0;
  int sensors = 0;
  for (const auto observed : {&FlashRecord::observed_a, &FlashRecord::observed_b}) {
    if (!known(before.*observed) || !known(flash.*observed)) continue;
    sum_ns += (flash.*observed - before.*observed).count();
    ++sensors;
  }
  if (sensors == 0) return;
  add(TimingQuantity::period_error, nanoseconds(sum_ns / sensors) - (flash.commanded - before.commanded));
}

}  // namespace strobe::firmware
