#include "common/impact/spatial/spatial_rebound.hpp"

#include "common/impact/closed_form/grip_impulse.hpp"

namespace strobe::impact {

Eigen::Vector2d along_surface(const Eigen::Vector3d& v) { return {v.x(), v.z()}; }

Eigen::Vector2d rolling_spin(const Eigen::Vector3d& omega) { return {omega.z(), -omega.x()}; }

std::array<Motion, 3> planar_parts(const SpatialMotion& m) {
  const double vy = m.velocity_mps.y();
  return {Motion{m.velocity_mps.x(), vy, m.spin_radps.z()}, Motion{m.velocity_mps.z(), vy, -m.spin_radps.x()},
          Motion{0.0, vy, m.spin_radps.y()}};
}

Eigen::Vector2d slip_mps(const ball::Ball& ball, const SpatialMotion& m) {
  // The small difference of large numbers: one rounding only.
  return {std::fma(ball.radius_m(), m.spin_radps.z(), m.velocity_mps.x()),
          std::fma(-ball.radius_m(), m.spin_radps.x(), m.velocity_mps.z())};
}

SpatialMotion changed(const SpatialMotion& touchdown, double vy_mps, const Eigen::Vector2d& dv_mps,
                      const Eigen::Vector2d& dspin_radps) {
  SpatialMotion out = touchdown;
  out.velocity_mps += Eigen::Vector3d(dv_mps.x(), 0.0, dv_mps.y());
  out.velocity_mps.y() = vy_mps;
  out.spin_radps += Eigen::Vector3d(-dspin_radps.y(), 0.0, dspin_radps.x());
  return out;
}

Regime regime_of(const ball::Ball& ball, const SpatialMotion& touchdown, const SpatialRebound& rebound) {
  const Eigen::Vector2d change =
      along_surface(rebound.lift_off.velocity_mps) - along_surface(touchdown.velocity_mps);
  return regime_of_exact(slip_mps(ball, touchdown).norm(), change.norm(), ball.alpha);
}

tl::expected<SpatialRebound, InputError> grip(const ball::Ball& ball, const SpatialMotion& touchdown,
                                              const Coefficients& c) {
  for (const Motion& part : planar_parts(touchdown))
    if (const auto error = detail::find_error(ball, part, c)) return tl::unexpected(*error);
  const double radius = ball.radius_m(), vy = touchdown.velocity_mps.y();
  const double impulse = -(1.0 + c.e) * vy;
  const Eigen::Vector2d spin = radius * rolling_spin(touchdown.spin_radps);
  const Eigen::Vector2d rolling = 0.5 * (along_surface(touchdown.velocity_mps) - spin);
  const auto change = detail::grip_impulse(ball, slip_mps(ball, touchdown), spin, rolling, impulse, c);

  SpatialRebound out;
  out.lift_off = changed(touchdown, -c.e * vy, change.dv, change.dspin / radius);
  out.regime = change.grips ? Regime::grips : Regime::slides;
  out.slip_lo_mps = change.slip_lo;
  out.impulse_ratio = change.dv.norm() / impulse;
  out.offset_m = change.offset;
  return out;
}

tl::expected<SpatialRebound, InputError> rigid(const ball::Ball& ball, const SpatialMotion& touchdown,
                                               double e, double mu) {
  return grip(ball, touchdown, Coefficients{.e = e, .mu = mu});
}

}  // namespace strobe::impact
