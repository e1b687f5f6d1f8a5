// Distribution of lateness in a fixed table: 64 steps per octave from 1 ns to 17 s, so a percentile is exact
// within 1.6 %. No allocation; one thread's. After the log-linear histogram of G. Tene's HdrHistogram.
#pragma once

#include <array>
#include <cstdint>

#include "common/units/time.hpp"

namespace strobe::firmware {

class LatenessHistogram {
 public:
  void add(Duration lateness) noexcept;  ///< negative counts as 0
  std::int64_t count() const noexcept { return count_; }
  Duration max() const noexcept { return max_; }
  /// Smallest lateness that a share (0 to 1) of all does not exceed, to the table's step; 0 if there is none.
  Duration percentile(double share) const noexcept;

 private:
  static constexpr int kStepBits = 6;
  static constexpr int kOctaves = 29;
  static constexpr std::size_t kBins = static_cast<std::size_t>(kOctaves) << kStepBits;
  static std::size_t bin_of(std::int64_t ns) noexcept;
  static std::int64_t last_of(std::size_t bin) noexcept;  ///< largest value of the bin

  std::array<std::int64_t, kBins> bins_{};
  std::int64_t count_ = 0;
  Duration max_{0};
};

}  // namespace strobe::firmware
