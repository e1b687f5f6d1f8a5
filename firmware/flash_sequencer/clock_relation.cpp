#include "firmware/flash_sequencer/clock_relation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strobe::firmware {

using flash_sequencer::kTick_ns;
using flash_sequencer::Ticks;

namespace {

/// Of a beta distribution on that width, its mean at that share of it; its parameters are 2 together.
double beta_variance(double width, double mean) { return width * width * mean * (1.0 - mean) / 3.0; }

}  // namespace

void ClockRelation::Scatter::add(double above_ns) noexcept {
  constexpr int kBeats = 128;
  constexpr double kLongest_ns = 100e3;  // a stall says nothing of what is usual
  if (count < kBeats) ++count;
  mean_ns += (std::min(above_ns, kLongest_ns) - mean_ns) / count;
}

/// Of the width between the bounds, what the requests take of it.
double ClockRelation::request_share() const noexcept {
  const double requests_ns = kStampSd_ns + requests_.mean_ns;
  return requests_ns / (requests_ns + kStampSd_ns + replies_.mean_ns);
}

/// Without the drift: as it would be at the reference, relative to it.
double ClockRelation::level(const Bound& bound) const noexcept {
  return static_cast<double>(bound.offset_ns - reference_.offset_ns) -
         slope_ * static_cast<double>(bound.at_ns - reference_.at_ns);
}

/// Bounds that the line misses by far: the rate of either clock has been changed, by NTP for one.
bool ClockRelation::contradicted(const Bound& lower, const Bound& upper) const noexcept {
  const double slack_ns = 10e3 + 5.0 * static_cast<double>(sd(lower.at_ns / kTick_ns).count());
  return level(lower) - slack_ns > offset_ns_ || level(upper) + slack_ns < offset_ns_;
}

void ClockRelation::observe(MonoTime not_before, Ticks ticks, MonoTime not_after) noexcept {
  if (not_after < not_before) return;  // no bracket of that request
  const std::int64_t at_ns = ticks * kTick_ns;
  const Bound lower{at_ns, to_ns(not_before) - at_ns};
  const Bound upper{at_ns, to_ns(not_after) - at_ns};
  if (known_ && contradicted(lower, upper)) forget();
  const std::int64_t number = at_ns / kBucket_ns;
  Bucket& bucket = buckets_[static_cast<std::size_t>(number) % kBuckets];
  if (bucket.number != number) {
    bucket = {number, lower, upper};
  } else {
    if (level(lower) > level(bucket.lower)) bucket.lower = lower;
    if (level(upper) < level(bucket.upper)) bucket.upper = upper;
  }
  requests_.add(level(bucket.lower) - level(lower));
  replies_.add(level(upper) - level(bucket.upper));
  if (!known_) reference_ = {at_ns, lower.offset_ns + (upper.offset_ns - lower.offset_ns) / 2};
  known_ = true;
  newest_ = number;
  fit();
}

/// Of offset = a + b (t - t0), by the normal equations; the new slope changes the points a little.
void ClockRelation::fit() noexcept {
  constexpr int kRounds = 2;
  const double share = request_share();
  const Bound old = reference_;
  reference_.at_ns = newest_ * kBucket_ns + kBucket_ns / 2;
  reference_.offset_ns += std::llround(slope_ * static_cast<double>(reference_.at_ns - old.at_ns));
  for (int round = 0; round < kRounds; ++round) {
    double weights = 0.0, times = 0.0, squares = 0.0, offsets = 0.0, products = 0.0;
    double least_width = std::numeric_limits<double>::max();
    for (const Bucket& bucket : buckets_) {
      if (bucket.number < 0 || bucket.number + static_cast<std::int64_t>(kBuckets) <= newest_) continue;
      const double lower = level(bucket.lower), upper = level(bucket.upper);
      const double width = std::max(0.0, upper - lower);
      least_width = std::min(least_width, width);
      const double at = 0.5 * static_cast<double>((bucket.lower.at_ns - reference_.at_ns) +
                                                  (bucket.upper.at_ns - reference_.at_ns));
      const double point = lower + share * (upper - lower) + slope_ * at;
      const double weight = 1.0 / (beta_variance(width, share) + kBucketSd_ns * kBucketSd_ns);
      weights += weight;
      times += weight * at;
      squares += weight * at * at;
      offsets += weight * point;
      products += weight * at * point;
    }
    squares += 1.0 / (kDriftSd * kDriftSd);
    const double determinant = weights * squares - times * times;
    offset_ns_ = (squares * offsets - times * products) / determinant;
    slope_ = (weights * products - times * offsets) / determinant;
    variance_ns2_ = squares / determinant;
    covariance_ns_ = -times / determinant;
    slope_variance_ = weights / determinant;
    common_variance_ns2_ = beta_variance(least_width, share) + kStampSd_ns * kStampSd_ns;
  }
}

MonoTime ClockRelation::to_time(Ticks ticks) const noexcept {
  const std::int64_t at_ns = ticks * kTick_ns;
  const double after_ns = static_cast<double>(at_ns - reference_.at_ns);
  return from_ns(at_ns + reference_.offset_ns + std::llround(offset_ns_ + slope_ * after_ns));
}

Ticks ClockRelation::to_ticks(MonoTime time) const noexcept {
  const auto since_ns = static_cast<double>(to_ns(time) - reference_.at_ns - reference_.offset_ns);
  const double after_ns = (since_ns - offset_ns_) / (1.0 + slope_);
  const double whole_ns = static_cast<double>(reference_.at_ns % kTick_ns) + after_ns;
  return reference_.at_ns / kTick_ns + std::llround(whole_ns / static_cast<double>(kTick_ns));
}

Duration ClockRelation::sd(Ticks ticks) const noexcept {
  const double after_ns = static_cast<double>(ticks * kTick_ns - reference_.at_ns);
  const double variance_ns2 = variance_ns2_ + 2.0 * covariance_ns_ * after_ns +
                              slope_variance_ * after_ns * after_ns + common_variance_ns2_;
  return Duration{std::llround(std::sqrt(std::max(0.0, variance_ns2)))};
}

}  // namespace strobe::firmware
