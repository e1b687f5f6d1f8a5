#include "common/contact/differentiation/constrained_motion.hpp"

#include <cmath>
#include <vector>

namespace strobe::contact {

namespace {

ValueSd times(const ValueSd& v, double factor) { return {v.value * factor, v.sd * std::abs(factor)}; }

std::optional<ConstrainedSpline> fitted(const std::vector<double>& t, const std::vector<double>& y,
                                        const EndConditions& ends, const SplineOptions& options) {
  auto fit = fit_constrained_spline(t, y, ends, options);
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

std::optional<ValueSd> scaled(const std::optional<ConstrainedSpline>& fit, double t, int order,
                              double factor) {
  if (!fit) return std::nullopt;
  return times(fit->derivative_with_sd(t, order), factor);
}

}  // namespace

Result<void> check(const ContactScale& s) {
  if (!(std::isfinite(s.dwell_time_s) && s.dwell_time_s > 0.0)) return fail("dwell time must be positive");
  if (!(std::isfinite(s.dwell_distance_m) && s.dwell_distance_m > 0.0))
    return fail("dwell distance must be positive");
  if (!(std::isfinite(s.diameter_m) && s.diameter_m > 0.0)) return fail("diameter must be positive");
  if (!(std::isfinite(s.mass_kg) && s.mass_kg > 0.0)) return fail("mass must be positive");
  if (!std::isfinite(s.total_rotation_rad)) return fail("total rotation must be a finite number");
  return {};
}

Result<ConstrainedMotion> fit_constrained_motion(const data::ContactSet& set, const ContactScale& s,
                                                 const EndVelocities& ends, bool no_force,
                                                 const SplineOptions& options) {
  if (const auto ok = check(s); !ok) return tl::unexpected(ok.error());
  std::vector<double> t, x, y, t_rotation, rotation;
  for (const data::ContactRow& row : set.rows) {
    if (!data::is_interior(row)) continue;
    t.push_back(row.time_fraction);
    x.push_back(row.x_fraction * s.dwell_distance_m);
    y.push_back(row.y_fraction * s.diameter_m);
    if (!row.rotation_fraction) continue;
    t_rotation.push_back(row.time_fraction);
    rotation.push_back(*row.rotation_fraction * s.total_rotation_rad);
  }
  const double dwell = s.dwell_time_s;
  const EndConditions along{0.0, s.dwell_distance_m, times(ends.vx_td_mps, dwell),
                            times(ends.vx_lo_mps, dwell), no_force};
  const EndConditions normal{0.0, 0.0, times(ends.vy_td_mps, dwell), times(ends.vy_lo_mps, dwell), no_force};
  const EndConditions turn{0.0, s.total_rotation_rad, times(ends.omega_td_radps, dwell),
                           times(ends.omega_lo_radps, dwell), no_force};
  return ConstrainedMotion{fitted(t, x, along, options), fitted(t, y, normal, options),
                           fitted(t_rotation, rotation, turn, options), s};
}

DerivedState derive(const ConstrainedMotion& m, double t) {
  const ContactScale& s = m.scale;
  const double rate = 1.0 / s.dwell_time_s, rate2 = rate * rate;
  DerivedState out{.x_m = scaled(m.x, t, 0, 1.0),
                   .y_m = scaled(m.y, t, 0, 1.0),
                   .rotation_rad = scaled(m.rotation, t, 0, 1.0),
                   .vx_mps = scaled(m.x, t, 1, rate),
                   .vy_mps = scaled(m.y, t, 1, rate),
                   .omega_radps = scaled(m.rotation, t, 1, rate),
                   .fx_n = scaled(m.x, t, 2, s.mass_kg * rate2),
                   .fy_n = scaled(m.y, t, 2, s.mass_kg * rate2),
                   .torque_nm = scaled(m.rotation, t, 2, s.inertia_kgm2() * rate2),
                   .slip_mps = std::nullopt};
  out.slip_mps = slip_of(out, 0.5 * s.diameter_m);
  return out;
}

std::optional<ForcePeak> largest_normal_force(const ConstrainedMotion& motion) {
  if (!motion.y) return std::nullopt;
  constexpr int kSteps = 1000;
  int best = 0;
  for (int i = 1; i <= kSteps; ++i)
    if (motion.y->curvature(static_cast<double>(i) / kSteps) >
        motion.y->curvature(static_cast<double>(best) / kSteps))
      best = i;
  const double fraction = static_cast<double>(best) / kSteps;
  return ForcePeak{*derive(motion, fraction).fy_n, fraction};
}

}  // namespace strobe::contact
