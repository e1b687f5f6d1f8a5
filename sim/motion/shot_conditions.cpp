#include "sim/motion/shot_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

/// Smallest stiffness ratio after a draw.
constexpr double kMinStiffnessRatio = 0.01;
constexpr double kMinRestitution = 0.05, kMaxRestitution = 0.99;

}  // namespace

ShotConditions draw_shot_conditions(const Scene& scene, std::uint64_t seed, int shot) {
  const MachineSettings& m = scene.machine;
  const BounceSettings& b = scene.bounce;
  const auto number = static_cast<std::uint64_t>(shot);
  Draws machine(seed, Purpose::machine, number);
  const double speed = std::max(0.5, machine.normal(m.speed_mps, m.speed_sd_mps));
  const double angle =
      std::clamp(machine.normal(m.angle_rad, m.angle_sd_rad), -0.5 * std::numbers::pi, -0.03);

  ShotConditions t;
  t.touchdown = {speed * std::cos(angle), speed * std::sin(angle),
                 machine.normal(m.spin_radps, m.spin_sd_radps)};
  t.lag_s = std::max(0.001, machine.normal(m.lag_s, m.lag_sd_s));
  t.spot_m = machine.normal(0.0, m.spot_sd_m);
  t.equator_rad = machine.uniform() * std::numbers::pi;
  t.off_plane_m = Draws(seed, Purpose::off_plane, number).normal(0.0, scene.camera.off_plane_sd_m);

  Draws bounce(seed, Purpose::bounce, number);
  const double e_mean = b.e + b.e_slope_spm * (std::abs(t.touchdown.vy_mps) - b.e_speed_mps);
  t.coefficients.e = std::clamp(bounce.normal(e_mean, b.e_sd), kMinRestitution, kMaxRestitution);
  const double grip = bounce.normal();
  const double rho = b.offset_grip_correlation;
  const double offset = rho * grip + std::sqrt(1.0 - rho * rho) * bounce.normal();
  t.coefficients.mu = std::max(0.0, b.mu + b.mu_sd * grip);
  t.coefficients.e_x = std::clamp(b.ex + b.ex_sd * grip, -1.0, 1.0);
  t.coefficients.offset_m = std::clamp(b.offset_m + b.offset_sd_m * offset, 0.0, 0.9 * scene.ball.radius_m());
  t.stiffness_ratio = std::clamp(b.stiffness_ratio + b.stiffness_ratio_sd * grip, kMinStiffnessRatio, 1e3);
  t.offset_share = std::clamp(b.offset_share + b.offset_share_sd * offset, 0.0, 1.0);
  t.dwell_s = std::clamp(bounce.normal(b.dwell_s, b.dwell_sd_s), 0.5 * b.dwell_s, 1.5 * b.dwell_s);
  return t;
}

ShotConditions conditions_of_next_bounce(const Scene& scene, const ShotConditions& before,
                                         const impact::Motion& touchdown) {
  ShotConditions next = before;
  next.touchdown = touchdown;
  const double faster_mps = std::abs(touchdown.vy_mps) - std::abs(before.touchdown.vy_mps);
  next.coefficients.e = std::clamp(before.coefficients.e + scene.bounce.e_slope_spm * faster_mps,
                                   kMinRestitution, kMaxRestitution);
  return next;
}

Scene without_spread(Scene scene) {
  MachineSettings& m = scene.machine;
  m.speed_sd_mps = m.angle_sd_rad = m.spin_sd_radps = m.lag_sd_s = m.spot_sd_m = 0.0;
  BounceSettings& b = scene.bounce;
  b.e_sd = b.mu_sd = b.dwell_sd_s = b.ex_sd = b.stiffness_ratio_sd = 0.0;
  b.offset_sd_m = b.offset_share_sd = 0.0;
  scene.camera.off_plane_sd_m = 0.0;
  return scene;
}

}  // namespace strobe::sim
