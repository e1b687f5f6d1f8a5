#include "common/flight/parabola.hpp"

#include <cmath>

namespace strobe::flight {

namespace {

/// Beyond this the computation of the instant might overflow.
constexpr double kMaxTime_s = 1e100;

/// Solves drop = v·t + a·t²/2 for the root at which the velocity is `sign`·sqrt(v² + 2·a·drop). Of the two
/// ways of writing that root the one that adds numbers of like sign is taken, so that no digits cancel.
std::optional<double> root_s(double v, double a, double drop, double sign) {
  const double discriminant = v * v + 2.0 * a * drop;
  if (!(discriminant >= 0.0)) return std::nullopt;
  const double v_there = sign * std::sqrt(discriminant);
  if (v * v_there > 0.0) return 2.0 * drop / (v + v_there);
  if (a != 0.0 && std::abs(v_there - v) <= std::abs(a) * kMaxTime_s) return (v_there - v) / a;
  if (v == 0.0 && drop == 0.0) return 0.0;
  return std::nullopt;
}

}  // namespace

Eigen::Vector2d gravity_mps2(double inclination_rad) {
  return {-kStandardGravity_mps2 * std::sin(inclination_rad),
          -kStandardGravity_mps2 * std::cos(inclination_rad)};
}

Eigen::Vector2d Parabola::position_at(double time_s) const {
  return position + time_s * (velocity + 0.5 * acceleration * time_s);
}

Eigen::Vector2d Parabola::velocity_at(double time_s) const { return velocity + acceleration * time_s; }

std::optional<double> Parabola::time_falling_through_s(double height) const {
  return root_s(velocity.y(), acceleration.y(), height - position.y(), -1.0);
}

std::optional<double> Parabola::time_rising_through_s(double height) const {
  return root_s(velocity.y(), acceleration.y(), height - position.y(), 1.0);
}

}  // namespace strobe::flight
