// Trajectories held against the images of a set, and the total rotation of a set.
#include <cmath>
#include <vector>

#include "common/contact/integration/integration.hpp"

namespace strobe::contact {

namespace {

struct Angles {
  std::vector<double> fraction;
  std::vector<double> predicted_rad;
};

Result<void> check(const SetScale& scale) {
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
    const double miss = total_rad * a.fraction[i] - a.predicted_rad[i];
    squares += miss * miss;
  }
  const double see = std::sqrt(squares / static_cast<double>(a.fraction.size() - 1));
  RotationError error{.total_rad = total_rad, .see_rad = see, .see_fraction = std::nullopt};
  if (total_rad != 0.0) error.see_fraction = see / std::abs(total_rad);
  return error;
}

std::optional<RotationScore> rotation_score(const Angles& a, double own_total_rad, const SetScale& scale) {
  double qq = 0.0, qp = 0.0, pp = 0.0;
  for (std::size_t i = 0; i < a.fraction.size(); ++i) {
    qq += a.fraction[i] * a.fraction[i];
    qp += a.fraction[i] * a.predicted_rad[i];
    pp += a.predicted_rad[i] * a.predicted_rad[i];
  }
  if (a.fraction.size() < 2 || !(qq > 0.0)) return std::nullopt;
  RotationScore out;
  out.n = static_cast<int>(a.fraction.size());
  out.own_total = rotation_error(a, own_total_rad);
  out.fitted_total = rotation_error(a, qp / qq);
  out.fitted_total_sd_rad = out.fitted_total.see_rad / std::sqrt(qq);
  if (pp > 0.0) out.r_squared = (qp / qq) * (qp / pp);
  if (scale.total_rotation_rad) out.given_total = rotation_error(a, *scale.total_rotation_rad);
  return out;
}

}  // namespace

Result<Score> score(const ContactSet& set, const Trajectory& trajectory, const SetScale& scale) {
  if (const auto ok = check(scale); !ok) return tl::unexpected(ok.error());
  Score out;
  Angles angles;
  double squares_x = 0.0, squares_y = 0.0;
  for (const ContactRow& row : set.rows) {
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
  out.rotation = rotation_score(angles, trajectory(1.0).rotation_rad, scale);
  return out;
}

Trajectory trajectory_of(const SpinPulse& pulse) {
  return [pulse](double time_fraction) {
    const ContactState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, s.rotation_rad};
  };
}

Trajectory trajectory_of(const impact::SinePulse& pulse) {
  return [pulse](double time_fraction) {
    const impact::PulseState s = pulse.at_fraction(time_fraction);
    return TrajectoryPoint{s.x_m, s.y_m, 0.0};
  };
}

/// With the Hermite cubics h = 3T² - 2T³ (rises from 0 to 1) and g (the spins' share) the residual is
/// S·(q - h) - dwell·g, linear in S.
Result<EndSpinTotal> end_spin_total(const ContactSet& set, double omega_td_radps, double omega_lo_radps,
                                    double dwell_s) {
  if (!std::isfinite(omega_td_radps) || !std::isfinite(omega_lo_radps) || !std::isfinite(dwell_s))
    return fail("spins and dwell time must be finite numbers");
  if (dwell_s <= 0.0) return fail("dwell time must be positive");
  double uu = 0.0, ug = 0.0, gg = 0.0;
  EndSpinTotal out;
  for (const ContactRow& row : set.rows) {
    if (is_end_point(row) || !row.rotation_fraction) continue;
    const double t = row.time_fraction, rest = 1.0 - t;
    const double u = *row.rotation_fraction - t * t * (3.0 - 2.0 * t);
    const double g = dwell_s * t * rest * (omega_td_radps * rest - omega_lo_radps * t);
    uu += u * u;
    ug += u * g;
    gg += g * g;
    ++out.n;
  }
  if (out.n < 2 || !(uu > 0.0))
    return fail("at least two rotations are needed between touchdown and lift-off");
  out.total_rad = ug / uu;
  out.residual_rad = std::sqrt(std::max(0.0, gg - ug * (ug / uu)) / (out.n - 1));
  out.sd_rad = out.residual_rad / std::sqrt(uu);
  return out;
}

}  // namespace strobe::contact
