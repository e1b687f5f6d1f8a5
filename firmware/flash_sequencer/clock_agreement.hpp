// How the stamps of one clock, related to another, compare with that other's own stamps of the same edges.
#pragma once

#include <cmath>
#include <cstddef>

#include "common/units/time.hpp"

namespace strobe::firmware {

/// Mean and scatter of differences (Welford, Technometrics 4 (1962) 419). Real-time safe; a plain value.
class ClockAgreement {
 public:
  static constexpr std::size_t kMinCount = 20;  ///< that are worth relating clocks by

  void add(Duration difference) noexcept {
    const auto ns = static_cast<double>(difference.count());
    const double before = ns - mean_ns_;
    mean_ns_ += before / static_cast<double>(++count_);
    squares_ns2_ += before * (ns - mean_ns_);
  }
  std::size_t count() const noexcept { return count_; }
  double mean() const noexcept { return mean_ns_; }  ///< [ns]
  /// Of one difference, and of the mean [ns]. Valid: count() >= 2.
  double sd() const noexcept { return std::sqrt(squares_ns2_ / static_cast<double>(count_ - 1)); }
  double mean_sd() const noexcept { return sd() / std::sqrt(static_cast<double>(count_)); }

 private:
  std::size_t count_ = 0;
  double mean_ns_ = 0.0;
  double squares_ns2_ = 0.0;
};

}  // namespace strobe::firmware
