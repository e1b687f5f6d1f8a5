// Timing of all flashes since the start, as published in the status: lateness and duration of each
// set-values call as it is issued, the sensors' delays when a shot has ended. Fixed memory (0.3 MB), no
// allocation; one thread's.
#pragma once

#include <array>
#include <cstdint>

#include "common/units/time.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

/// Distribution of a signed duration in fixed tables: 256 steps per octave from 1 ns to 17 s on either side
/// of zero, so that a percentile is exact within 0.4 %. After the log-linear histogram of G. Tene's
/// HdrHistogram; mean and sd by B. P. Welford's recurrence (Technometrics 4, 1962).
class TimingHistogram {
 public:
  /// Some 20 equal bins over the middle 99 %, of a width that is 1, 2 or 5 times a power of ten [ns]. The
  /// first and the last also count what lies beyond them.
  struct Coarse {
    static constexpr std::size_t kMax = 24;
    Duration first{};  ///< lower edge of the first bin
    Duration width{};
    std::size_t count = 0;  ///< of bins; 0 if there are no values
    std::array<std::int64_t, kMax> bins{};
  };

  void add(Duration value) noexcept;
  std::int64_t count() const noexcept { return count_; }
  double mean_ns() const noexcept { return mean_ns_; }  ///< 0 if there is none
  double sd_ns() const noexcept;                        ///< population; 0 if there is none
  Duration min() const noexcept { return min_; }
  Duration max() const noexcept { return max_; }
  /// Smallest value that a share (0 to 1) of all does not exceed, to the table's step; 0 if there is none.
  Duration percentile(double share) const noexcept;
  Coarse coarse() const noexcept;

 private:
  static constexpr int kStepBits = 8;
  static constexpr int kOctaves = 27;
  static constexpr std::size_t kBins = static_cast<std::size_t>(kOctaves) << kStepBits;
  /// Values of either sign by magnitude; a bin that is full stays full.
  using Table = std::array<std::uint32_t, kBins>;

  static std::size_t bin_of(std::uint64_t magnitude_ns) noexcept;
  static std::int64_t first_of(std::size_t bin) noexcept;  ///< smallest magnitude of the bin
  static std::int64_t last_of(std::size_t bin) noexcept;   ///< largest
  template <typename Skip, typename Visit>
  void visit_in_order(Skip&& skip, Visit&& visit) const noexcept;

  Table negative_{};
  Table positive_{};
  std::array<std::array<std::int64_t, kOctaves>, 2> in_octave_{};  ///< sums of either table's octaves
  std::int64_t count_ = 0;
  double mean_ns_ = 0.0;
  double squares_ns2_ = 0.0;  ///< sum of squares about the mean
  Duration min_{};
  Duration max_{};
};

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
