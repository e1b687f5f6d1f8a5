#include "common/contact/cross_validation.hpp"

#include <cmath>
#include <utility>

namespace strobe::contact {

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
