#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "sim/motion/flight.hpp"

namespace strobe::sim {

Flight::Flight(const Scene& scene, const FlightState& start, const Eigen::Vector3d& spin_radps,
               const Model& model)
    : Flight(scene, start, spin_radps.norm(), model) {
  spatial_ = true;
  if (start_.omega_radps > 0.0) axis_ = spin_radps / start_.omega_radps;
}

namespace {

/// Place, velocity, and the spin with its angle, about an axis that stays.
using Spatial = Eigen::Matrix<double, 8, 1>;

Spatial spatial_of(const FlightState& s) {
  return Spatial{s.x_m, s.y_m, s.z_m, s.vx_mps, s.vy_mps, s.vz_mps, s.omega_radps, s.rotation_rad};
}

// 0 over 0 is none of the ball's speeds.
constexpr double kSlowest = std::numeric_limits<double>::min();

template <typename Law>
Spatial spatial_slope(const Law& law, const Eigen::Vector3d& axis, const Spatial& s) {
  const Eigen::Vector3d v = s.segment<3>(3);
  const double speed = v.norm(), omega = s[6];
  const Eigen::Vector3d across = axis.cross(v);
  const double rim = law.radius_m * omega * across.norm() / std::max(speed, kSlowest);
  const double lift = law.lift_pm * speed * law.radius_m * omega /
                      std::max(law.lift_slope * rim + law.lift_offset * speed, kSlowest);
  Spatial out;
  out.head<3>() = v;
  out.segment<3>(3) =
      Eigen::Vector3d(law.gravity_x_mps2, law.gravity_y_mps2, 0.0) - law.drag_pm * speed * v + lift * across;
  out[6] = -law.decay_pm * speed * omega;
  out[7] = omega;
  return out;
}

}  // namespace

FlightState Flight::spatial_step(const FlightState& start, double h_s) const {
  const Spatial s = spatial_of(start);
  const Spatial a = spatial_slope(law_, axis_, s);
  const Spatial b = spatial_slope(law_, axis_, Spatial(s + 0.5 * h_s * a));
  const Spatial c = spatial_slope(law_, axis_, Spatial(s + 0.5 * h_s * b));
  const Spatial d = spatial_slope(law_, axis_, Spatial(s + h_s * c));
  const Spatial end = s + h_s / 6.0 * (a + 2.0 * b + 2.0 * c + d);
  return {end[0], end[1], end[3], end[4], end[6], end[7], end[2], end[5]};
}

}  // namespace strobe::sim
