#include "common/impact/closed_form/turf.hpp"

#include <cmath>

#include "common/units/angles.hpp"

namespace strobe::impact {

namespace {

/// As seen from axes turned counter-clockwise.
Motion turned(const Motion& m, double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {m.vx_mps * c + m.vy_mps * s, m.vy_mps * c - m.vx_mps * s, m.omega_radps};
}

}  // namespace

double contact_plane_tilt_rad(const Motion& touchdown) {
  const double speed = std::hypot(touchdown.vx_mps, touchdown.vy_mps);
  const double theta = std::atan2(touchdown.vx_mps, -touchdown.vy_mps);
  return radians(15.4) * (speed / 18.6) * (theta / radians(44.4));
}

tl::expected<Rebound, InputError> rigid_on_turf(const ball::Ball& ball, const Motion& touchdown, double e,
                                                double mu) {
  constexpr int kHalvings = 60;
  if (const auto level = rigid(ball, touchdown, e, mu); !level) return level;
  const double beta = contact_plane_tilt_rad(touchdown);
  const Motion seen = turned(touchdown, beta);
  double low = 0.0, high = 1.0;
  tl::expected<Rebound, InputError> out = tl::unexpected(InputError::restitution_out_of_range);
  const auto excess = [&](double restitution) {
    out = rigid(ball, seen, restitution, mu);
    if (!out) return 0.0;
    out->lift_off = turned(out->lift_off, -beta);
    return out->lift_off.vy_mps + e * touchdown.vy_mps;
  };
  if (excess(low) > 0.0 || excess(high) < 0.0) return tl::unexpected(InputError::restitution_out_of_range);
  for (int i = 0; i < kHalvings && out; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) < 0.0 ? low : high) = middle;
  }
  return out;
}

}  // namespace strobe::impact
