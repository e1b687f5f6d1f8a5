#include "common/geometry/leg.hpp"

#include <cassert>

namespace strobe::geometry {

void LegFit::add(double time_s, const Eigen::Vector2d& centre, double weight) {
  assert(weight > 0.0);
  if (count_++ == 0) first_s_ = time_s;
  line_.add(time_s, centre - fall(time_s), weight);
}

flight::Parabola LegFit::path() const {
  const double t = mean_time_s() - first_s_;
  return {line_.mean() + fall(mean_time_s()), line_.slope() + t * gravity_, gravity_};
}

std::optional<Crossing> crossing(const LegFit& leg, double height, double nearest_s) {
  if (!leg.has_velocity()) return std::nullopt;
  const flight::Parabola path = leg.path();
  const double up = path.velocity_at(nearest_s - leg.mean_time_s()).y();
  if (up == 0.0) return std::nullopt;
  const auto t = up < 0.0 ? path.time_falling_through_s(height) : path.time_rising_through_s(height);
  if (!t) return std::nullopt;
  return Crossing{leg.mean_time_s() + *t, path.position_at(*t), path.velocity_at(*t)};
}

}  // namespace strobe::geometry
