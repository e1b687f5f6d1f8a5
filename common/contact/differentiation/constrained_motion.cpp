#include "common/contact/differentiation/constrained_motion.hpp"

#include <cmath>
#include <vector>

namespace strobe::contact {

namespace {

bool usable(const ContactRow& row) {
  return !is_end_point(row) && row.time_fraction >= 0.0 && row.time_fraction <= 1.0;
}

Result<void> check(const Scale& s) {
  if (!(std::isfinite(s.dwell_time_s) && s.dwell_time_s > 0.0)) return fail("dwell time must be positive");
  if (!(std::isfinite(s.dwell_distance_m) && s.dwell_distance_m > 0.0))
    return fail("dwell distance must be positive");
  if (!(std::isfinite(s.diameter_m) && s.diameter_m > 0.0)) return fail("diameter must be positive");
  if (!(std::isfinite(s.mass_kg) && s.mass_kg > 0.0)) return fail("mass must be positive");
  if (!std::isfinite(s.total_rotation_rad)) return fail("total rotation must be a finite number");
  return {};
}

ValueSd times(const ValueSd& v, double factor) { return {v.value * factor, v.sd * std::abs(factor)}; }

std::optional<ConstrainedFit> fitted(const std::vector<double>& t, const std::vector<double>& y,
                                     const EndConditions& ends, const ConstrainedFitOptions& options) {
  auto fit = fit_constrained(t, y, ends, options);
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

std::optional<ValueSd> scaled(const std::optional<ConstrainedFit>& fit, double t, int order, double factor) {
  if (!fit) return std::nullopt;
  return times(fit->derivative_with_sd(t, order), factor);
}

double value_or_zero(const std::optional<ConstrainedFit>& fit, double t) { return fit ? fit->value(t) : 0.0; }

/// Sum of squares over images, and their number.
struct Squares {
  double sum = 0.0;
  int n = 0;
  void add(double error) {
    sum += error * error;
    ++n;
  }
  std::optional<double> root_mean() const {
    if (n == 0) return std::nullopt;
    return std::sqrt(sum / n);
  }
};

struct Tally {
  Squares cubic, spline, pulse;
  LeaveOneOut result() const { return {cubic.root_mean(), spline.root_mean(), pulse.root_mean()}; }
};

struct Left {
  FractionFits cubics;
  ConstrainedMotion spline;
};

Left fit_without(const ContactSet& set, std::size_t left_out, const Scale& scale, const EndVelocities& ends,
                 bool no_force, const ConstrainedFitOptions& options) {
  ContactSet rest{.name = set.name, .rows = {}};
  for (std::size_t i = 0; i < set.rows.size(); ++i)
    if (i != left_out) rest.rows.push_back(set.rows[i]);
  auto spline = fit_constrained_motion(rest, scale, ends, no_force, options);
  return {fit_fractions(rest), spline ? *std::move(spline) : ConstrainedMotion{}};
}

void add(Tally& tally, double measured, double factor, double t, const std::optional<CubicFit>& cubic,
         const std::optional<ConstrainedFit>& spline, double pulse) {
  if (cubic) tally.cubic.add(cubic->value(t) * factor - measured);
  if (spline) tally.spline.add(spline->value(t) - measured);
  tally.pulse.add(pulse - measured);
}

}  // namespace

Result<ConstrainedMotion> fit_constrained_motion(const ContactSet& set, const Scale& s,
                                                 const EndVelocities& ends, bool no_force,
                                                 const ConstrainedFitOptions& options) {
  if (const auto ok = check(s); !ok) return tl::unexpected(ok.error());
  std::vector<double> t, x, y, t_rotation, rotation;
  for (const ContactRow& row : set.rows) {
    if (!usable(row)) continue;
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
  const Scale& s = m.scale;
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

Trajectory trajectory_of(const ConstrainedMotion& m) {
  return [m](double t) {
    return TrajectoryPoint{value_or_zero(m.x, t), value_or_zero(m.y, t), value_or_zero(m.rotation, t)};
  };
}

Trajectory trajectory_of(const FractionFits& fits, const Scale& scale) {
  return [fits, scale](double t) {
    return TrajectoryPoint{fits.x ? fits.x->value(t) * scale.dwell_distance_m : 0.0,
                           fits.y ? fits.y->value(t) * scale.diameter_m : 0.0,
                           fits.rotation ? fits.rotation->value(t) * scale.total_rotation_rad : 0.0};
  };
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

Result<CrossValidation> leave_one_out(const ContactSet& set, const Scale& scale, const EndVelocities& ends,
                                      const Trajectory& pulse, bool no_force,
                                      const ConstrainedFitOptions& options) {
  if (const auto ok = check(scale); !ok) return tl::unexpected(ok.error());
  CrossValidation out;
  Tally x, y, rotation;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    const ContactRow& row = set.rows[i];
    if (!usable(row)) continue;
    ++out.n;
    const double t = row.time_fraction;
    const Left left = fit_without(set, i, scale, ends, no_force, options);
    const TrajectoryPoint p = pulse(t);
    add(x, row.x_fraction * scale.dwell_distance_m, scale.dwell_distance_m, t, left.cubics.x, left.spline.x,
        p.x_m);
    add(y, row.y_fraction * scale.diameter_m, scale.diameter_m, t, left.cubics.y, left.spline.y, p.y_m);
    if (!row.rotation_fraction) continue;
    const double total = scale.total_rotation_rad;
    add(rotation, *row.rotation_fraction * total, total, t, left.cubics.rotation, left.spline.rotation,
        p.rotation_rad);
  }
  out.x_m = x.result();
  out.y_m = y.result();
  out.rotation_rad = rotation.result();
  return out;
}

}  // namespace strobe::contact
