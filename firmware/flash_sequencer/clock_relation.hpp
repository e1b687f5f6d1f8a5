// The relation of a flash sequencer's clock to CLOCK_MONOTONIC, from requests that it stamped: the stamp is
// of the instant at which the request's last byte has left; or, where the line does not tell
// when that is, between the earliest end of its transmission and the latest begin of the reply's.
//
// Of each quarter of a second the latest begin and the earliest end count, so that delays of either way (a
// busy machine, a stall) matter only if all have them. What all requests or all replies take at least cannot
// be told apart from the clocks' offset; but a way whose delays scatter little has a short least one. So the
// width that is left between the two is divided as the ways' scatter is, and taken for a beta distribution of
// that mean (for equal scatter the uniform one). A straight line is fitted to those points of the last four
// seconds, by least squares with weights, and with what crystals may do as prior of its slope.
#pragma once

#include <array>
#include <cmath>

#include "common/flash_sequencer/protocol.hpp"
#include "common/units/time.hpp"

namespace strobe::firmware {

/// Real-time safe, one thread's. Deterministic.
class ClockRelation {
 public:
  /// not_before, not_after: between which the sequencer's clock was at `ticks`. Times go on, never back.
  void observe(MonoTime not_before, flash_sequencer::Ticks ticks, MonoTime not_after) noexcept;
  /// All of it: the clock was started anew.
  void forget() noexcept { *this = {}; }

  /// Moves it by what better observations say; sd_ns of that. Nothing is observed afterwards.
  void shift(double offset_ns, double sd_ns) noexcept {
    offset_ns_ += offset_ns;
    common_variance_ns2_ = sd_ns * sd_ns;
  }

  bool known() const noexcept { return known_; }
  // Valid: known().
  MonoTime to_time(flash_sequencer::Ticks ticks) const noexcept;
  flash_sequencer::Ticks to_ticks(MonoTime time) const noexcept;  ///< to the nearest
  /// Of to_time(): one standard deviation.
  Duration sd(flash_sequencer::Ticks ticks) const noexcept;
  double drift() const noexcept { return slope_; }  ///< of CLOCK_MONOTONIC against it: 1e-6 is 1 ppm
  double drift_sd() const noexcept { return known_ ? std::sqrt(slope_variance_) : kDriftSd; }

 private:
  static constexpr std::int64_t kBucket_ns = 250'000'000;
  static constexpr std::size_t kBuckets = 16;
  static constexpr double kDriftSd = 60e-6;      ///< of two crystals
  static constexpr double kBucketSd_ns = 100.0;  ///< at least
  static constexpr double kStampSd_ns = 300.0;   ///< of its stamps, which are of whole microseconds

  struct Bound {
    std::int64_t at_ns = 0;      ///< by the sequencer's clock
    std::int64_t offset_ns = 0;  ///< of CLOCK_MONOTONIC to it
  };
  struct Bucket {
    std::int64_t number = -1;
    Bound lower, upper;
  };

  /// Of a way's delays above the least one of their quarter of a second: the mean of late.
  struct Scatter {
    double mean_ns = 0.0;
    int count = 0;
    void add(double above_ns) noexcept;
  };

  double level(const Bound& bound) const noexcept;
  double request_share() const noexcept;
  bool contradicted(const Bound& lower, const Bound& upper) const noexcept;
  void fit() noexcept;

  std::array<Bucket, kBuckets> buckets_;
  Scatter requests_, replies_;
  bool known_ = false;
  std::int64_t newest_ = 0;  ///< bucket
  Bound reference_;          ///< the line's offsets are relative to it
  double offset_ns_ = 0.0;   ///< at the reference
  double slope_ = 0.0;
  double variance_ns2_ = 0.0, covariance_ns_ = 0.0, slope_variance_ = 0.0;
  double common_variance_ns2_ = 0.0;  ///< of what all observations share
};

}  // namespace strobe::firmware
