// Timing of all flashes since the start, as published in the status: lateness and duration of each
// set-values call as it is issued, the sensors' delays when a shot has ended. Fixed memory (0.3 MB); one
// thread's.
#pragma once

#include <array>

#include "firmware/core/timing_histogram.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

/// Values are those of histogram_t.
enum class TimingQuantity : std::int8_t {
  lateness = 1,  ///< issue_start - commanded
  issue,         ///< issue_end - issue_start
  skew,          ///< observed_a - observed_b
  lamp_delay_a,  ///< observed_a - issue_end
  lamp_delay_b,
  period_error  ///< observed interval to the planned flash before - commanded one
};
inline constexpr std::array<TimingQuantity, 6> kTimingQuantities{
    TimingQuantity::lateness,     TimingQuantity::issue,        TimingQuantity::skew,
    TimingQuantity::lamp_delay_a, TimingQuantity::lamp_delay_b, TimingQuantity::period_error};

class ShotTiming {
 public:
  /// A flash has been issued.
  void issued(MonoTime commanded, MonoTime start, MonoTime end) noexcept;
  /// A shot is over: its flashes as seen.
  void seen(const ShotRecord& shot) noexcept;

  const TimingHistogram& of(TimingQuantity quantity) const noexcept {
    return histograms_[static_cast<std::size_t>(quantity) - 1];
  }

 private:
  void add(TimingQuantity quantity, Duration value) noexcept {
    histograms_[static_cast<std::size_t>(quantity) - 1].add(value);
  }
  void add_interval(const FlashRecord& before, const FlashRecord& flash) noexcept;

  std::array<TimingHistogram, kTimingQuantities.size()> histograms_;
};

}  // namespace strobe::firmware
