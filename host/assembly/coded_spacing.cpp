#include "host/assembly/coded_spacing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "host/assembly/assemble.hpp"
#include "host/assembly/drop_plan.hpp"
#include "host/assembly/flash_times.hpp"

namespace strobe::host {
namespace {

// A place that differs by d standard deviations of what the images tell has exp(-d^2/2 + d z) of the true
// one's likelihood, z standard normal. In 99 of 100 shots four neighbours together, as a lattice has them,
// then have less than kDroppedProbability: d^2/2 - 2.33 d >= ln 400.
constexpr double kSeparation = 6.5;
// A change of one between three images' intervals leaves residuals of 1, -2, 1 sixths.
const double kResidualOfChange = 1.0 / std::sqrt(6.0);
// Of a coordinate of a centre: twice that of rendered photographs (host/digitize/README.md), for real ones
// are less clear.
constexpr double kDigitizerSd_px = 0.1;
// By how much the mean interval may be longer than the period: a dozen images then lose at most one.
constexpr double kMaxLengthening = 1.0 / 12.0;
constexpr int kImagesOfLeg = 3;
// The longest pulse that a rig file allows: the burst must end before the shutter closes.
constexpr Duration kLongestPulse = milliseconds{10};

/// Digits of a code, the intervals in steps above the period. The pair of changes of both legs is nowhere the
/// same: the one between three flashes of the incoming leg, and a lag later that of the rebound.
class Digits {
 public:
  Digits(int levels, std::vector<std::size_t> lags)
      : levels_(levels),
        lags_(std::move(lags)),
        taken_(lags_.size(), std::vector<char>(changes() * changes(), 0)),
        used_(changes(), 0) {}

  /// Of each next digit that of the least cost(). Returns nullopt if at some place every digit repeats a
  /// pair.
  std::optional<std::vector<int>> run(std::size_t count) {
    while (digits_.size() < count) {
      const auto digit = digits_.empty() ? std::optional(0) : next();
      if (!digit) return std::nullopt;
      append(*digit);
    }
    return digits_;
  }

 private:
  std::size_t changes() const { return static_cast<std::size_t>(2 * levels_ - 1); }
  std::size_t change_to(int digit) const {
    return static_cast<std::size_t>(digit - digits_.back() + levels_ - 1);
  }
  char& taken(std::size_t lag, std::size_t change) {
    return taken_[lag][history_[history_.size() - lags_[lag]] * changes() + change];
  }

  bool is_new(std::size_t change) {
    for (std::size_t lag = 0; lag < lags_.size(); ++lag)
      if (history_.size() >= lags_[lag] && taken(lag, change) != 0) return false;
    return true;
  }

  /// Changes that came often so far leave fewer new pairs; high digits lengthen the train.
  int cost(int digit) const { return 2 * used_[change_to(digit)] + digit; }

  std::optional<int> next() {
    std::optional<int> best;
    for (int digit = 0; digit < levels_; ++digit) {
      if (best && cost(digit) >= cost(*best)) continue;
      if (is_new(change_to(digit))) best = digit;
    }
    return best;
  }

  void append(int digit) {
    if (!digits_.empty()) {
      const std::size_t change = change_to(digit);
      for (std::size_t lag = 0; lag < lags_.size(); ++lag)
        if (history_.size() >= lags_[lag]) taken(lag, change) = 1;
      history_.push_back(change);
      ++used_[change];
    }
    digits_.push_back(digit);
  }

  int levels_;
  std::vector<std::size_t> lags_;  ///< in flashes, from the incoming leg's three to the rebound's
  std::vector<std::vector<char>> taken_;
  std::vector<int> used_;
  std::vector<std::size_t> history_;  ///< changes so far, from 0
  std::vector<int> digits_;
};

/// As many flashes lie between the legs as the shortest and the longest contact takes.
std::vector<std::size_t> lags_between_legs(Duration period, const matching::DwellLimits& contact) {
  const double period_s = to_seconds(period);
  const auto first = static_cast<std::size_t>(std::floor(contact.least_s / period_s));
  const auto last = static_cast<std::size_t>(std::ceil(contact.most_s / period_s));
  std::vector<std::size_t> lags(last - first + 1);
  std::iota(lags.begin(), lags.end(), first + kImagesOfLeg);
  return lags;
}

/// By how much intervals differ at the least. A faster ball leaves fewer images: those of three a leg are a
/// diameter apart or more.
Duration step_of(Duration period, const SpacingNoise& noise) {
  const double by_centre_us = to_microseconds(period) * noise.centre_sd_of_diameter;
  const double sd_us = std::hypot(by_centre_us, 1e6 * noise.flash_time_sd_s);
  return microseconds{std::llround(std::ceil(kSeparation / kResidualOfChange * sd_us))};
}

std::size_t flashes_of(const ShotPlan& even) {
  if (even.train == Train::gated) return static_cast<std::size_t>(even.flash_count);
  return static_cast<std::size_t>((even.exposure + even.period - Duration{1}) / even.period);
}

SpacingNoise noise_of(const RigFile& rig, bool digitized) {
  const auto px_per_m = rig.camera.px_per_m ? rig.camera.px_per_m : rig.analysis.px_per_m;
  const double centre_sd = digitized && px_per_m ? kDigitizerSd_px / (*px_per_m * rig.ball.diameter_m)
                                                 : matching::kHandSdOfDiameter;
  return {centre_sd, rig.analysis.flash_time_sd_s.value_or(kSensorTimeSd_s), contact_of(rig.ball)};
}

Result<std::vector<Duration>> intervals_of(const ShotPlan& even, const SpacingNoise& noise) {
  const auto intervals = coded_intervals(even.period, flashes_of(even), noise);
  if (!intervals || even.train != Train::gated) return intervals;
  const Duration burst =
      std::accumulate(intervals->begin(), intervals->end(), even.gate_delay + kLongestPulse);
  if (burst > even.exposure) return fail("the coded burst would outlast the exposure");
  return intervals;
}

}  // namespace

Result<std::vector<Duration>> coded_intervals(Duration period, std::size_t flashes,
                                              const SpacingNoise& noise) {
  if (flashes > kMaxCodedFlashes)
    return fail(fmt::format("a coded train has at most {} flashes", kMaxCodedFlashes));
  const Duration step = step_of(period, noise);
  if (flashes < 2) return std::vector<Duration>{};
  for (int levels = 2; (levels - 1) * step <= period / 2; ++levels) {
    const auto digits = Digits(levels, lags_between_legs(period, noise.contact)).run(flashes - 1);
    if (!digits) continue;
    const double lengthening = std::accumulate(digits->begin(), digits->end(), 0.0) * to_seconds(step) /
                               static_cast<double>(digits->size());
    if (lengthening > kMaxLengthening * to_seconds(period)) break;
    std::vector<Duration> intervals;
    for (const int digit : *digits) intervals.push_back(period + digit * step);
    return intervals;
  }
  return fail(fmt::format(
      "the period is too short to code {} flashes: intervals would have to differ by {:.0f} us or more",
      flashes, to_microseconds(step)));
}

SpacedPlan spaced_plan(const PlanFile& given, const RigFile& rig, bool digitized) {
  SpacedPlan spaced{given, ""};
  if (given.drop_height_m > 0.0) {
    auto drop = drop_plan(given, rig);
    if (!drop) spaced.problem = drop.error().message;
    if (drop) spaced.plan = std::move(*drop);
  }
  const PlanFile plan = spaced.plan;
  if (plan.drop_height_m > 0.0 && spaced.problem.empty())
    spaced.remark =
        fmt::format("for a drop from {:g} m: {:g} ms from flash to flash, for {:g} ms", plan.drop_height_m,
                    1e3 * to_seconds(plan.even.period), 1e3 * to_seconds(plan.even.exposure));
  if (plan.spacing == Spacing::even) return spaced;
  if (!spaced.remark.empty()) spaced.remark += "; ";
  spaced.plan.spacing = Spacing::even;
  auto intervals = intervals_of(plan.even, noise_of(rig, digitized));
  if (!intervals) {
    spaced.remark += fmt::format("even train: {}{}", intervals.error().message,
                                 digitized ? "" : " on a photograph that is measured by hand");
  } else if (!intervals->empty()) {
    spaced.remark += fmt::format(
        "coded train: intervals of {} to {:.0f} us tell which flash made which image",
        to_microseconds(plan.even.period), to_microseconds(*std::ranges::max_element(*intervals)));
    spaced.plan.intervals = std::move(*intervals);
  }
  return spaced;
}

}  // namespace strobe::host
