#include "sim/fit/fit.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "common/units/angles.hpp"
#include "sim/fit/bounce.hpp"
#include "sim/rig/tablet.hpp"

namespace strobe::sim {

namespace {

using reduction::Quantity;
using thesis::Condition;
using thesis::MeanSd;

constexpr double kPeriod_s = 0.003;
constexpr double kShare = 0.9;
constexpr double kMaxCentreNoise_m = 0.5e-3;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kMaxEquatorNoise_rad = kDegree;
constexpr double kNoMiss = 0.01;

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

void note_miss(FittedScene& fitted, Quantity quantity, double published_sd, double expected_sd) {
  if (std::abs(expected_sd - published_sd) > kNoMiss * published_sd)
    fitted.missed.push_back({quantity, published_sd, expected_sd});
}

Result<void> fit_means(FittedScene& fitted, const Condition& c) {
  Scene& scene = fitted.scene;
  scene.ball.alpha = impact::kContactAlpha;
  MachineSettings& m = scene.machine;
  m.speed_mps = std::hypot(c.vx_td_mps.mean, c.vy_td_mps.mean);
  m.angle_rad = std::atan2(c.vy_td_mps.mean, c.vx_td_mps.mean);
  m.spin_radps = c.omega_td_radps.mean;
  if (auto done = fit_coefficients(scene, c); !done) return done;
  const auto end = mean_lift_off(scene);
  if (!end) return tl::unexpected(end.error());
  fitted.slides = end->rebound.regime == Regime::slides;
  fitted.left_vx_mps = end->rebound.lift_off.vx_mps - c.vx_lo_mps.mean;
  fitted.left_omega_radps = end->rebound.lift_off.omega_radps - c.omega_lo_radps.mean;
  return {};
}

void fit_noise_and_machine(FittedScene& fitted, const Condition& c) {
  Scene& scene = fitted.scene;
  scene.tablet.centre_sd_m =
      std::min(kMaxCentreNoise_m, kShare * scene.tablet.centre_sd_m * admissible_noise(scene, c));
  scene.tablet.equator_sd_rad =
      std::min(kMaxEquatorNoise_rad,
               kShare * std::min(c.omega_td_radps.sd, c.omega_lo_radps.sd) * kPeriod_s / std::numbers::sqrt2);
  const TwoPointNoise n =
      two_point_noise(scene, c.vx_td_mps.mean, c.vy_td_mps.mean, images_of_shot(scene, c));
  scene.machine.speed_sd_mps = left_over(c.v_td_mps.sd, n.along_mps);
  scene.machine.angle_sd_rad = left_over(c.theta_in_deg.sd * kDegree, n.across_rad);
  scene.machine.spin_sd_radps = left_over(c.omega_td_radps.sd, n.spin_radps);
}

void fit_bounce(FittedScene& fitted, const Condition& c) {
  const TwoPointNoise n =
      two_point_noise(fitted.scene, c.vx_lo_mps.mean, c.vy_lo_mps.mean, images_of_shot(fitted.scene, c));
  const LiftOffVariances noise{square(component_noise(n, c.vx_lo_mps.mean, c.vy_lo_mps.mean)),
                               square(component_noise(n, c.vy_lo_mps.mean, c.vx_lo_mps.mean)),
                               square(n.spin_radps)};
  const LiftOffVariances made = fit_spreads(
      fitted.scene, noise, {square(c.vx_lo_mps.sd), square(c.vy_lo_mps.sd), square(c.omega_lo_radps.sd)});
  note_miss(fitted, Quantity::vx_lo_mps, c.vx_lo_mps.sd, std::sqrt(made.vx));
  note_miss(fitted, Quantity::vy_lo_mps, c.vy_lo_mps.sd, std::sqrt(made.vy));
  note_miss(fitted, Quantity::omega_lo_radps, c.omega_lo_radps.sd, std::sqrt(made.spin));
}

void fit_dwell(FittedScene& fitted, const Condition& c) {
  // Each end is where a line through two images is extended by 0 to 1 interval: variance c²·(2u² + 2u + 1),
  // 8/3 on average over u; the surface line's height adds c²/4, the radius c²·2/diameters.
  Scene& scene = fitted.scene;
  const double end_m =
      scene.tablet.centre_sd_m * std::sqrt(8.0 / 3.0 + 0.25 + 2.0 / images_of_shot(scene, c));
  const double noise_s = end_m * std::hypot(1.0 / c.vy_td_mps.mean, 1.0 / c.vy_lo_mps.mean);
  scene.bounce.dwell_sd_s = left_over(c.dwell_time_ms.sd * 1e-3, noise_s);
  note_miss(fitted, Quantity::dwell_time_ms, c.dwell_time_ms.sd,
            std::hypot(noise_s, scene.bounce.dwell_sd_s) * 1e3);
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
  if (auto done = fit_means(fitted, condition); !done)
    return fail(condition.name() + ": " + done.error().message);
  fit_noise_and_machine(fitted, condition);
  fit_bounce(fitted, condition);
  fit_dwell(fitted, condition);
  return fitted;
}

namespace {

std::string spin_words(const std::string& spin) {
  if (spin == "zero") return "no spin";
  return spin == "top" ? "topspin" : "backspin";
}

std::string entry(const char* key, double value) { return fmt::format("{} = {:.8g}\n", key, value); }
std::string spread(const char* key, double sd) {
  return sd > 0.0 ? fmt::format("{} = {:.6g}\n", key, sd) : "";
}

std::string left_over(const FittedScene& fitted, const thesis::Condition& c) {
  return fmt::format(
      "# Left of the published lift-off, simulated less published: vx {:.3f} m/s ({:.2f} sd), "
      "spin {:.2f} rad/s ({:.2f} sd).\n",
      fitted.left_vx_mps, fitted.left_vx_mps / c.vx_lo_mps.sd, fitted.left_omega_radps,
      fitted.left_omega_radps / c.omega_lo_radps.sd);
}

std::string bounce(const BounceSettings& b) {
  std::string text = "\n[bounce]\ncontact = \"ode\"\n";
  text += entry("e", b.e) + entry("e_speed_mps", b.e_speed_mps) + spread("e_sd", b.e_sd);
  text += entry("mu", b.mu) + spread("mu_sd", b.mu_sd);
  text += entry("stiffness_ratio", b.stiffness_ratio) + spread("stiffness_ratio_sd", b.stiffness_ratio_sd);
  text += entry("damping_ratio", b.damping_ratio);
  text += entry("offset_share", b.offset_share) + spread("offset_share_sd", b.offset_share_sd);
  if (b.offset_share_sd > 0.0) text += entry("offset_grip_correlation", b.offset_grip_correlation);
  text += entry("dwell_ms", b.dwell_s * 1e3) + spread("dwell_sd_ms", b.dwell_sd_s * 1e3);
  return text;
}

}  // namespace

std::string to_toml(const FittedScene& fitted, const thesis::Condition& condition) {
  const MachineSettings& m = fitted.scene.machine;
  const TabletSettings& t = fitted.scene.tablet;
  std::string text = "# Written by `strobe-sim fit` from the thesis's tables; sim/fit/fit.hpp says how.\n";
  text += fitted.slides ? "# The ball slides throughout.\n" : "# The ball grips.\n";
  text += left_over(fitted, condition);
  for (const MissedSpread& miss : fitted.missed)
    text += fmt::format("# {}: published sd {:.3g}, here {:.3g}.\n", reduction::name(miss.quantity),
                        miss.published_sd, miss.expected_sd);
  text += fmt::format("title = \"{}, {:.2f} degrees\"\n", spin_words(condition.spin),
                      condition.theta_in_deg.mean);
  text += "\n[ball]\n" + fmt::format("alpha = {}\n", fitted.scene.ball.alpha);
  text += "\n[machine]\n";
  text += entry("speed_mps", m.speed_mps) + spread("speed_sd_mps", m.speed_sd_mps);
  text += entry("angle_deg", degrees(m.angle_rad)) + spread("angle_sd_deg", degrees(m.angle_sd_rad));
  text += entry("spin_radps", m.spin_radps) + spread("spin_sd_radps", m.spin_sd_radps);
  text += bounce(fitted.scene.bounce);
  text += "\n[tablet]\n";
  text += fmt::format("centre_sd_mm = {:.6g}\nequator_sd_deg = {:.6g}\n", t.centre_sd_m * 1e3,
                      degrees(t.equator_sd_rad));
  return text;
}

}  // namespace strobe::sim
