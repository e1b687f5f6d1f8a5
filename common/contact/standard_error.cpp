#include "common/contact/standard_error.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace strobe::contact {

Trajectory trajectory_of(const impact::SinePulse& pulse) {
  return [pulse](double time_fraction) {
    const impact::PulseState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, 0.0};
  };
}

Trajectory trajectory_of(const SpinPulse& pulse) {
  return [pulse](double time_fraction) {
    const SpinPulseState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, s.rotation_rad};
  };
}

Trajectory trajectory_of(const impact::ContactTrajectory& ode) {
  return [ode](double time_fraction) {
    const impact::ContactState s = ode.at(time_fraction * ode.summary().dwell_s);
    return TrajectoryPoint{s.x_m, s.y_m, s.rotation_rad};
  };
}

Trajectory trajectory_of(const ConstrainedMotion& motion) {
  return [motion](double time_fraction) {
    const auto value = [&](const std::optional<ConstrainedSpline>& spline) {
      return spline ? spline->value(time_fraction) : 0.0;
    };
    return TrajectoryPoint{value(motion.x), value(motion.y), value(motion.rotation)};
  };
}

namespace {

struct Angles {
  std::vector<double> fraction;
  std::vector<double> predicted_rad;
};

Result<void> check(const FractionScale& scale) {
  if (!(std::isfinite(scale.dwell_distance_m) && scale.dwell_distance_m > 0.0))
    return fail("dwell distance must be positive");
  if (!(std::isfinite(scale.diameter_m) && scale.diameter_m > 0.0)) return fail("diameter must be positive");
  if (scale.total_rotation_rad && !std::isfinite(*scale.total_rotation_rad))
    return fail("total rotation must be a finite number");
  return {};
}

RotationError rotation_error(const Angles& a, double total_rad) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.fraction.size(); ++i) {
    const double residual = total_rad * a.fraction[i] - a.predicted_rad[i];
    squares += residual * residual;
  }
  const double see = std::sqrt(squares / static_cast<double>(a.fraction.size() - 1));
  RotationError error{.total_rad = total_rad, .see_rad = see, .see_fraction = std::nullopt};
  if (total_rad != 0.0) error.see_fraction = see / std::abs(total_rad);
  return error;
}

std::optional<RotationErrors> rotation_errors(const Angles& a, double own_total_rad,
                                              const FractionScale& scale) {
  double qq = 0.0, qp = 0.0, pp = 0.0;
  for (std::size_t i = 0; i < a.fraction.size(); ++i) {
    qq += a.fraction[i] * a.fraction[i];
    qp += a.fraction[i] * a.predicted_rad[i];
    pp += a.predicted_rad[i] * a.predicted_rad[i];
  }
  if (a.fraction.size() < 2 || !(qq > 0.0)) return std::nullopt;
  RotationErrors out;
  out.n = static_cast<int>(a.fraction.size());
  out.own_total = rotation_error(a, own_total_rad);
  out.fitted_total = rotation_error(a, qp / qq);
  if (out.fitted_total.see_rad > data::kRounding * std::sqrt(pp))
    out.fitted_total_sd_rad = out.fitted_total.see_rad / std::sqrt(qq);
  if (pp > 0.0) out.r_squared = (qp / qq) * (qp / pp);
  if (scale.total_rotation_rad) out.given_total = rotation_error(a, *scale.total_rotation_rad);
  return out;
}

}  // namespace

Result<StandardErrors> standard_errors(const data::ContactSet& set, const Trajectory& trajectory,
                                       const FractionScale& scale) {
  if (const auto ok = check(scale); !ok) return tl::unexpected(ok.error());
  StandardErrors out;
  Angles angles;
  double squares_x = 0.0, squares_y = 0.0;
  for (const data::ContactRow& row : set.rows) {
    if (is_end_point(row)) continue;
    const TrajectoryPoint p = trajectory(row.time_fraction);
    if (!std::isfinite(p.x_m) || !std::isfinite(p.y_m) || !std::isfinite(p.rotation_rad))
      return fail("the trajectory is not finite at an image");
    squares_x += std::pow(row.x_fraction * scale.dwell_distance_m - p.x_m, 2);
    squares_y += std::pow(row.y_fraction * scale.diameter_m - p.y_m, 2);
    ++out.n;
    if (!row.rotation_fraction) continue;
    angles.fraction.push_back(*row.rotation_fraction);
    angles.predicted_rad.push_back(p.rotation_rad);
  }
  if (out.n < 2) return fail("at least two rows are needed between touchdown and lift-off");
  out.see_x_m = std::sqrt(squares_x / (out.n - 1));
  out.see_y_m = std::sqrt(squares_y / (out.n - 1));
  out.rotation = rotation_errors(angles, trajectory(1.0).rotation_rad, scale);
  return out;
}

Result<StandardErrors> pulse_standard_errors(const data::ContactSet& set, const ContactInputs& in) {
  const FractionScale scale{.dwell_distance_m = in.dwell_distance_m,
                            .diameter_m = in.diameter_m,
                            .total_rotation_rad = std::nullopt};
  if (const auto ok = check(scale); !ok) return tl::unexpected(ok.error());
  const auto pulse = impact::SinePulse::make(in.form, {.vx_td_mps = in.vx_td_mps,
                                                       .vy_td_mps = in.vy_td_mps,
                                                       .e = in.e,
                                                       .impulse_ratio = in.mu,
                                                       .dwell_s = in.dwell_time_s});
  if (!pulse) return fail(std::string(impact::message(pulse.error())));
  return standard_errors(set, trajectory_of(*pulse), scale);
}

namespace {

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

struct Errors {
  Squares cubic, spline, pulse;
  LeaveOneOutRms rms() const { return {cubic.root_mean(), spline.root_mean(), pulse.root_mean()}; }
};

struct Fits {
  FractionFits cubics;
  ConstrainedMotion spline;
};

Fits fit_without(const data::ContactSet& set, std::size_t left_out, const ContactScale& scale,
                 const EndVelocities& ends, bool no_force, const SplineOptions& options) {
  data::ContactSet rest{.name = set.name, .rows = {}};
  for (std::size_t i = 0; i < set.rows.size(); ++i)
    if (i != left_out) rest.rows.push_back(set.rows[i]);
  auto spline = fit_constrained_motion(rest, scale, ends, no_force, options);
  return {fit_fractions(rest), spline ? *std::move(spline) : ConstrainedMotion{}};
}

void add(Errors& errors, double measured, double factor, double t, const std::optional<CubicFit>& cubic,
         const std::optional<ConstrainedSpline>& spline, double pulse) {
  if (cubic) errors.cubic.add(cubic->value(t) * factor - measured);
  if (spline) errors.spline.add(spline->value(t) - measured);
  errors.pulse.add(pulse - measured);
}

}  // namespace

Result<CrossValidation> leave_one_out(const data::ContactSet& set, const ContactScale& scale,
                                      const EndVelocities& ends, const Trajectory& pulse, bool no_force,
                                      const SplineOptions& options) {
  if (const auto ok = check(scale); !ok) return tl::unexpected(ok.error());
  CrossValidation out;
  Errors x, y, rotation;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    const data::ContactRow& row = set.rows[i];
    if (!data::is_interior(row)) continue;
    ++out.n;
    const double t = row.time_fraction;
    const Fits fits = fit_without(set, i, scale, ends, no_force, options);
    const TrajectoryPoint p = pulse(t);
    add(x, row.x_fraction * scale.dwell_distance_m, scale.dwell_distance_m, t, fits.cubics.x, fits.spline.x,
        p.x_m);
    add(y, row.y_fraction * scale.diameter_m, scale.diameter_m, t, fits.cubics.y, fits.spline.y, p.y_m);
    if (!row.rotation_fraction) continue;
    const double total = scale.total_rotation_rad;
    add(rotation, *row.rotation_fraction * total, total, t, fits.cubics.rotation, fits.spline.rotation,
        p.rotation_rad);
  }
  out.x_m = x.rms();
  out.y_m = y.rms();
  out.rotation_rad = rotation.rms();
  return out;
}

}  // namespace strobe::contact
