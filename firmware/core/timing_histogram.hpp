// Distribution of a signed duration in fixed tables: 256 steps per octave from 1 ns to 17 s on either side of
// zero, so that a percentile is exact within 0.4 %. No allocation; one thread's. After the log-linear
// histogram of G. Tene's HdrHistogram; mean and sd by B. P. Welford's recurrence (Technometrics 4, 1962).
#pragma once

#include <array>
#include <cstdint>

#include "common/units/time.hpp"

namespace strobe::firmware {

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

}  // namespace strobe::firmware
