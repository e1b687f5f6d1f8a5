#include "sim/rig/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/rig/ball_path.hpp"
#include "sim/rig/tablet.hpp"

namespace strobe::sim {

namespace {

using reduction::Quantity;
using thesis::Condition;
using thesis::MeanSd;

constexpr double kPeriod_s = 0.003;
constexpr double kShare = 0.9;
constexpr double kMostCentreNoise_m = 0.5e-3;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMostEquatorNoise_rad = kDegree;

double square(double x) { return x * x; }
double left_over(double sd, double noise) { return std::sqrt(std::max(0.0, square(sd) - square(noise))); }

/// How many images a straight leg leaves in the camera's view.
double images_of_leg(const Scene& scene, double vx_mps, double vy_mps) {
  const double height_m = scene.camera.height_m - scene.ball.radius_m();
  return std::min(scene.camera.half_width_m / std::abs(vx_mps), height_m / std::abs(vy_mps)) / kPeriod_s;
}

double images_of_shot(const Scene& scene, const Condition& c) {
  return images_of_leg(scene, c.vx_td_mps.mean, c.vy_td_mps.mean) +
         images_of_leg(scene, c.vx_lo_mps.mean, c.vy_lo_mps.mean) + c.dwell_time_ms.mean * 1e-3 / kPeriod_s;
}

/// Noise of a velocity component: `along` turned by the path's angle.
double component_noise(const TwoPointNoise& n, double component_mps, double other_mps) {
  const double v = std::hypot(component_mps, other_mps);
  return std::hypot(component_mps / v * n.along_mps, other_mps * n.across_rad);
}

/// The largest centre noise, relative to the scene's, that all published sds of the two legs admit.
double admissible_noise(const Scene& scene, const Condition& c) {
  double factor = 1e9;
  const double diameters = images_of_shot(scene, c);
  const auto leg = [&](const MeanSd& vx, const MeanSd& vy, const MeanSd& v, const MeanSd& angle_deg) {
    const TwoPointNoise n = two_point_noise(scene, vx.mean, vy.mean, diameters);
    factor = std::min({factor, vx.sd / component_noise(n, vx.mean, vy.mean),
                       vy.sd / component_noise(n, vy.mean, vx.mean), v.sd / n.along_mps,
                       angle_deg.sd * kDegree / n.across_rad});
  };
  leg(c.vx_td_mps, c.vy_td_mps, c.v_td_mps, c.theta_in_deg);
  leg(c.vx_lo_mps, c.vy_lo_mps, c.v_lo_mps, c.theta_out_deg);
  return factor;
}

void note_excess(FittedScene& fitted, Quantity quantity, double published_sd, double left_over_variance) {
  if (left_over_variance < 0.0)
    fitted.excesses.push_back({quantity, published_sd, std::sqrt(square(published_sd) - left_over_variance)});
}

void fit_means(FittedScene& fitted, const Condition& c) {
  Scene& scene = fitted.scene;
  MachineSettings& m = scene.machine;
  m.speed_mps = std::hypot(c.vx_td_mps.mean, c.vy_td_mps.mean);
  m.angle_rad = std::atan2(c.vy_td_mps.mean, c.vx_td_mps.mean);
  m.spin_radps = c.omega_td_radps.mean;

  const double radius = scene.ball.radius_m();
  const double alpha = scene.ball.alpha;
  const double dvx = c.vx_lo_mps.mean - c.vx_td_mps.mean;
  const double domega = c.omega_lo_radps.mean - c.omega_td_radps.mean;
  const double slip_td = c.vx_td_mps.mean + radius * c.omega_td_radps.mean;
  const double slip_lo = c.vx_lo_mps.mean + radius * c.omega_lo_radps.mean;
  BounceSettings& b = scene.bounce;
  b.contact = ContactLaw::grip;
  b.e = c.vy_lo_mps.mean / -c.vy_td_mps.mean;
  b.e_speed_mps = -c.vy_td_mps.mean;
  const double impulse = (1.0 + b.e) * -c.vy_td_mps.mean;
  const double acting_m = (alpha * square(radius) * domega - radius * dvx) / impulse;
  const double rolling = 0.5 * (c.vx_td_mps.mean - radius * c.omega_td_radps.mean);
  b.offset_m = std::max(0.0, acting_m * std::hypot(rolling, impact::kOffsetReferenceSpeed_mps) / rolling);
  fitted.slides = std::abs(dvx) < std::abs(slip_td) * alpha / (1.0 + alpha);
  if (fitted.slides) {
    b.mu = -dvx / impulse;
  } else {
    b.ex = std::clamp(-slip_lo / slip_td, -1.0, 1.0);
    b.mu = std::max(impact::kFittedToThesis.mu, -dvx / impulse + 2.0 * c.mu.sd);
  }
  b.dwell_s = c.dwell_time_ms.mean * 1e-3;
}

void fit_noise_and_machine(FittedScene& fitted, const Condition& c) {
  Scene& scene = fitted.scene;
  scene.tablet.centre_sd_m =
      std::min(kMostCentreNoise_m, kShare * scene.tablet.centre_sd_m * admissible_noise(scene, c));
  scene.tablet.equator_sd_rad =
      std::min(kMostEquatorNoise_rad,
               kShare * std::min(c.omega_td_radps.sd, c.omega_lo_radps.sd) * kPeriod_s / std::numbers::sqrt2);
  const TwoPointNoise n =
      two_point_noise(scene, c.vx_td_mps.mean, c.vy_td_mps.mean, images_of_shot(scene, c));
  scene.machine.speed_sd_mps = left_over(c.v_td_mps.sd, n.along_mps);
  scene.machine.angle_sd_rad = left_over(c.theta_in_deg.sd * kDegree, n.across_rad);
  scene.machine.spin_sd_radps = left_over(c.omega_td_radps.sd, n.spin_radps);
}

/// What a shot's lift-off depends on, at the scene's means.
struct Parameters {
  double speed, angle, spin, e, grip, offset;  // grip: e_x, or mu where the ball slides
};

impact::Motion lift_off(const FittedScene& fitted, const Parameters& p) {
  const BounceSettings& b = fitted.scene.bounce;
  const impact::Motion td{p.speed * std::cos(p.angle), p.speed * std::sin(p.angle), p.spin};
  impact::Coefficients c;
  c.e = p.e + b.e_slope_spm * (-td.vy_mps - b.e_speed_mps);
  c.mu = fitted.slides ? p.grip : b.mu;
  c.e_x = fitted.slides ? b.ex : p.grip;
  c.offset_m = p.offset;
  const auto rebound = impact::grip(fitted.scene.ball, td, c);
  return rebound ? rebound->lift_off : impact::Motion{};
}

/// Central difference of the lift-off for each parameter.
std::array<impact::Motion, 6> derivatives(const FittedScene& fitted) {
  const Scene& s = fitted.scene;
  const Parameters mean{s.machine.speed_mps,
                        s.machine.angle_rad,
                        s.machine.spin_radps,
                        s.bounce.e,
                        fitted.slides ? s.bounce.mu : s.bounce.ex,
                        s.bounce.offset_m};
  constexpr std::array<double Parameters::*, 6> fields{&Parameters::speed, &Parameters::angle,
                                                       &Parameters::spin,  &Parameters::e,
                                                       &Parameters::grip,  &Parameters::offset};
  constexpr std::array steps{1e-3, 1e-5, 1e-2, 1e-5, 1e-5, 1e-7};
  std::array<impact::Motion, 6> result;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    Parameters up = mean;
    Parameters down = mean;
    up.*fields[i] += steps[i];
    down.*fields[i] -= steps[i];
    const impact::Motion a = lift_off(fitted, up);
    const impact::Motion b = lift_off(fitted, down);
    const double step = 2.0 * steps[i];
    result[i] = {(a.vx_mps - b.vx_mps) / step, (a.vy_mps - b.vy_mps) / step,
                 (a.omega_radps - b.omega_radps) / step};
  }
  return result;
}

/// Standard deviations of grip (e_x or mu) and offset and their correlation that make changes of vx and spin
/// with the given variances: correlated such that the offset, which cannot be negative, is spread least.
void spread_grip_and_offset(FittedScene& fitted, const impact::Motion& per_grip,
                            const impact::Motion& per_offset, double vx_variance, double spin_variance) {
  BounceSettings& b = fitted.scene.bounce;
  const double determinant =
      per_grip.vx_mps * per_offset.omega_radps - per_offset.vx_mps * per_grip.omega_radps;
  if (determinant == 0.0) return;
  // (grip, offset) = inverse matrix times (vx, spin).
  const double grip_vx = per_offset.omega_radps / determinant;
  const double grip_spin = -per_offset.vx_mps / determinant;
  const double offset_vx = -per_grip.omega_radps / determinant;
  const double offset_spin = per_grip.vx_mps / determinant;
  const double vx_sd = std::sqrt(vx_variance);
  const double spin_sd = offset_vx * offset_spin > 0.0 ? -std::sqrt(spin_variance) : std::sqrt(spin_variance);
  const double grip_change = grip_vx * vx_sd + grip_spin * spin_sd;
  const double offset_change = offset_vx * vx_sd + offset_spin * spin_sd;
  (fitted.slides ? b.mu_sd : b.ex_sd) = std::abs(grip_change);
  b.offset_sd_m = std::abs(offset_change);
  b.offset_grip_correlation = grip_change * offset_change < 0.0 ? -1.0 : 1.0;
}

void fit_bounce(FittedScene& fitted, const Condition& c) {
  Scene& scene = fitted.scene;
  BounceSettings& b = scene.bounce;
  const TwoPointNoise n =
      two_point_noise(scene, c.vx_lo_mps.mean, c.vy_lo_mps.mean, images_of_shot(scene, c));
  const auto d = derivatives(fitted);
  const std::array spreads{scene.machine.speed_sd_mps, scene.machine.angle_sd_rad,
                           scene.machine.spin_sd_radps};
  double vx = square(c.vx_lo_mps.sd) - square(component_noise(n, c.vx_lo_mps.mean, c.vy_lo_mps.mean));
  double vy = square(c.vy_lo_mps.sd) - square(component_noise(n, c.vy_lo_mps.mean, c.vx_lo_mps.mean));
  double spin = square(c.omega_lo_radps.sd) - square(n.spin_radps);
  for (std::size_t i = 0; i < spreads.size(); ++i) {
    vx -= square(d[i].vx_mps * spreads[i]);
    vy -= square(d[i].vy_mps * spreads[i]);
    spin -= square(d[i].omega_radps * spreads[i]);
  }
  b.e_sd = std::sqrt(std::max(0.0, vy)) / std::abs(d[3].vy_mps);
  vx -= square(d[3].vx_mps * b.e_sd);
  spin -= square(d[3].omega_radps * b.e_sd);
  spread_grip_and_offset(fitted, d[4], d[5], std::max(0.0, vx), std::max(0.0, spin));
  note_excess(fitted, Quantity::vx_lo_mps, c.vx_lo_mps.sd, vx);
  note_excess(fitted, Quantity::vy_lo_mps, c.vy_lo_mps.sd, vy);
  note_excess(fitted, Quantity::omega_lo_radps, c.omega_lo_radps.sd, spin);
}

void fit_dwell(FittedScene& fitted, const Condition& c) {
  // Each end is where a line through two images is extended by 0 to 1 interval: variance c²·(2u² + 2u + 1),
  // 8/3 on average over u; the surface line's height adds c²/4, the radius c²·2/diameters.
  Scene& scene = fitted.scene;
  const double end_m =
      scene.tablet.centre_sd_m * std::sqrt(8.0 / 3.0 + 0.25 + 2.0 / images_of_shot(scene, c));
  const double noise_s = end_m * std::hypot(1.0 / c.vy_td_mps.mean, 1.0 / c.vy_lo_mps.mean);
  scene.bounce.dwell_sd_s = left_over(c.dwell_time_ms.sd * 1e-3, noise_s);
  note_excess(fitted, Quantity::dwell_time_ms, c.dwell_time_ms.sd,
              square(c.dwell_time_ms.sd) - square(noise_s * 1e3));
}

}  // namespace

TwoPointNoise two_point_noise(const Scene& scene, double vx_mps, double vy_mps, double diameters) {
  const double c = scene.tablet.centre_sd_m;
  const double v = std::hypot(vx_mps, vy_mps);
  const double isotropic = std::numbers::sqrt2 * c / kPeriod_s;
  const double scale = kDiameterNoiseRatio * c / (scene.ball.diameter_m * std::sqrt(diameters));
  const double arm_m = scene.camera.half_width_m * std::sqrt(2.0 * (square(0.95) + square(0.70)));
  return {.along_mps = std::hypot(isotropic, v * scale),
          .across_rad = std::hypot(isotropic / v, c / arm_m),
          .spin_radps = std::numbers::sqrt2 * scene.tablet.equator_sd_rad / kPeriod_s};
}

Result<FittedScene> fit_scene(const Condition& condition) {
  FittedScene fitted;
  fitted.scene.name = condition.name();
  fit_means(fitted, condition);
  fit_noise_and_machine(fitted, condition);
  fit_bounce(fitted, condition);
  fit_dwell(fitted, condition);
  Scene still = fitted.scene;
  still.machine.speed_sd_mps = still.machine.angle_sd_rad = still.machine.spin_sd_radps = 0.0;
  if (auto path = BallPath::make(still, draw_throw(still, 0, 1)); !path)
    return fail(condition.name() + ": " + path.error().message);
  return fitted;
}

}  // namespace strobe::sim
