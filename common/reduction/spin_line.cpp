#include "common/reduction/spin_line.hpp"

#include <algorithm>
#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::reduction {
namespace {

/// Times AirLaw::spin_decay_per_m: no ball's spin decays faster.
constexpr double kMaxDecayRatio = 3.0;
/// Of a residual's variance, or of chi squared: too little to be looked at.
constexpr double kNegligible = 1e-3;

/// The parabola by which another decay bends the angles, less the line through it.
class Bend {
 public:
  Bend(const std::vector<EquatorReading>& readings, const SpinLine& line) : mean_s_(line.mean_x()) {
    for (const EquatorReading& r : readings) {
      const double t = r.time_s - mean_s_;
      taken_.add(t, t * t, weight(r, line.slope()));
    }
    for (const EquatorReading& r : readings) {
      const double w = weight(r, line.slope());
      const double shape = at(r);
      by_misses_ += w * miss(r, line) * shape;
      squares_ += w * shape * shape;
    }
  }

  double at(const EquatorReading& r) const {
    const double t = r.time_s - mean_s_;
    return t * t - taken_.at(t);
  }
  double by_misses() const { return by_misses_; }
  double squares() const { return squares_; }

 private:
  double mean_s_;
  SpinLine taken_;
  double by_misses_ = 0.0;
  double squares_ = 0.0;
};

double cost_of_bent(const std::vector<EquatorReading>& readings, const SpinLine& line, double decay_per_s) {
  const Bend bend(readings, line);
  const double one = -0.5 * line.slope() * decay_per_s;  // of a decay that is larger by itself
  const auto [least, most] = std::minmax({-one, (kMaxDecayRatio - 1.0) * one});
  const double coefficient =
      bend.squares() > 0.0 ? std::clamp(bend.by_misses() / bend.squares(), least, most) : 0.0;
  double cost = 0.0;
  for (const EquatorReading& r : readings) {
    const double rest = miss(r, line) - coefficient * bend.at(r);
    cost += std::min(rest * rest * weight(r, line.slope()), kCostLimit);
  }
  return cost;
}

}  // namespace

double cost_at_any_decay(const std::vector<EquatorReading>& readings, const SpinLine& line,
                         double decay_per_s) {
  const double cost = cost_of_bent(readings, line, decay_per_s);
  if (cost <= static_cast<double>(readings.size())) return cost;  // as much as by noise alone
  return std::min(cost, cost_of_bent(readings, through_all(readings, line), decay_per_s));
}

void allow_for_decay(const std::vector<EquatorReading>& readings, const SpinLine& line, double decay_sd_per_s,
                     SpinFit& fit) {
  const double sd = 0.5 * fit.omega_radps * decay_sd_per_s;  // of the parabola's coefficient
  const double half_s = 0.5 * (readings.back().time_s - readings.front().time_s);
  // About the middle a parabola is within half of half_s squared of a constant.
  const double most = 0.25 * sd * sd * line.weight() * half_s * half_s * half_s * half_s;
  if (!(most >= kNegligible)) return;
  const Bend bend(readings, line);
  const double share = sd * sd / (1.0 + sd * sd * bend.squares());
  const double coefficient = share * bend.by_misses();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const double shape = bend.at(readings[i]);
    fit.residual_rad[i] -= coefficient * shape;
    fit.leverage[i] += share * weight(readings[i], fit.omega_radps) * shape * shape;
  }
  fit.chi_squared -= coefficient * bend.by_misses();
  fit.decay_square = coefficient * coefficient / (sd * sd);
}

}  // namespace strobe::reduction
