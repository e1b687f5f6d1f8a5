// The straight line that the equator's angles follow in a time that runs slower as the spin decays, and what
// another decay than the assumed one, which is known in its order only, makes of the angles. Part of the
// reduction, not of its interface. Thread-safe; no allocation.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "common/geometry/leg.hpp"
#include "common/reduction/spin_fit.hpp"
#include "common/units/angles.hpp"

namespace strobe::reduction {

/// angle = mean + omega (t - mean time)
using SpinLine = geometry::LinearRegression<double>;

/// A reading whose squared deviation is more than this many variances costs no more: it is wrong, not
/// unlikely.
inline constexpr double kCostLimit = 16.0;

/// Inverse variance of a reading's angle, of a ball that spins so fast.
inline double weight(const EquatorReading& r, double omega) {
  const double by_time = omega * r.time_sd_s;
  return 1.0 / (r.sd_rad * r.sd_rad + by_time * by_time);
}

/// What a reading misses the line by, to the nearest half turn. [rad]
inline double miss(const EquatorReading& r, const SpinLine& line) {
  return wrap_half_turn(r.angle_rad - line.at(r.time_s));
}

/// Whether a line's chi squared, with two degrees of freedom less than readings, is beyond 4 of its sd: its
/// variance is twice its mean.
inline bool improbable(double chi_squared, std::size_t readings) {
  const double freedom = static_cast<double>(readings) - 2.0;
  return chi_squared > freedom + 4.0 * std::sqrt(2.0 * freedom);
}

/// Least squares through all readings, each at the half turn nearest to the given line.
inline SpinLine through_all(const std::vector<EquatorReading>& readings, const SpinLine& nearby) {
  SpinLine line;
  for (const EquatorReading& r : readings) {
    const double expected = nearby.at(r.time_s);
    line.add(r.time_s, expected + wrap_half_turn(r.angle_rad - expected), weight(r, nearby.slope()));
  }
  return line;
}

/// Cost of the readings' distances from the line, in variances up to kCostLimit each, with the decay that
/// suits it best, from none to three times `decay_per_s`, with which the readings were stretched: a faster
/// spin bends the angle more, which is no evidence against it as long as nobody knows the decay well. Of a
/// line that left out what a bend took away from it the one through all readings counts, if it costs less.
double cost_at_any_decay(const std::vector<EquatorReading>& readings, const SpinLine& line,
                         double decay_per_s);

/// Takes out of the residuals of `fit` what the likeliest decay explains of them, the decay being known to
/// `decay_sd_per_s` before, and adds what it takes to their leverage. `line` is the readings' least squares
/// line. The spin and its variance stay.
/// Source: linear model with a random effect, e.g. Koch, Parameter Estimation and Hypothesis Testing, 3.6: of
/// a parabola's coefficient -omega delta / 2, delta the decay's error.
void allow_for_decay(const std::vector<EquatorReading>& readings, const SpinLine& line, double decay_sd_per_s,
                     SpinFit& fit);

}  // namespace strobe::reduction
