#include "tests/sim/effects/random_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace strobe::sim::test {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : random_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(random_() >> 11) * 0x1p-53);
  }
  /// Evenly on a scale of factors.
  double factor(double low, double high) { return low * std::pow(high / low, between(0.0, 1.0)); }
  bool chance(double probability) { return between(0.0, 1.0) < probability; }
  /// A spread: none, or anything up to `most`.
  double spread(double most) { return chance(0.4) ? 0.0 : factor(0.02, 1.0) * most; }

 private:
  std::mt19937_64 random_;
};

void draw_bench(Dice& dice, Scene& scene) {
  scene.lamps.delay_s = dice.chance(0.2) ? 0.0 : dice.factor(1e-6, 60e-6);
  scene.lamps.jitter_s = dice.spread(3e-6);
  scene.lamps.flash_s = dice.chance(0.2) ? 0.0 : dice.factor(0.2e-6, 40e-6);
  scene.lamps.recharge_s = 0.4e-3;
  scene.sensors.delay_s = dice.chance(0.5) ? 0.0 : dice.factor(0.1e-6, 10e-6);
  scene.sensors.jitter_s = dice.spread(0.6e-6);
  scene.shutter.lag_sd_s = dice.spread(0.5e-3);
  TabletSettings& t = scene.tablet;
  t.centre_sd_m = dice.spread(0.8e-3);
  t.equator_sd_rad = dice.spread(1.5 * kDegree);
  t.visible_flattening_m = dice.between(0.3e-3, 2e-3);
  if (dice.chance(0.3)) t.calibration_sd = dice.chance(0.3) ? 0.0 : dice.factor(1e-4, 1e-2);
}

void draw_camera(Dice& dice, Scene& scene) {
  CameraSettings& c = scene.camera;
  c.px_per_m = dice.factor(800.0, 9000.0);
  c.roll_rad = dice.between(-3.0, 3.0) * kDegree;
  c.half_width_m = dice.between(0.2, 0.6);
  c.height_m = dice.between(0.2, 0.7);
  c.mirrored = dice.chance(0.5);
  if (dice.chance(0.5)) {
    c.distance_m = dice.factor(1.0, 8.0);
    c.off_plane_sd_m = dice.spread(0.015);
  }
  if (dice.chance(0.5)) c.distortion = (dice.chance(0.5) ? 1.0 : -1.0) * dice.factor(1e-5, 0.04);
  c.pixels = dice.chance(0.2);
  if (c.pixels) c.px_per_m = std::min(c.px_per_m, 4000.0);
}

void draw_shot_conditions(Dice& dice, Scene& scene) {
  scene.ball.diameter_m = dice.between(0.04, 0.09);
  scene.ball.mass_kg = dice.factor(0.02, 0.2);
  scene.ball.alpha = dice.between(0.4, 2.0 / 3.0);
  scene.surface_angle_rad = dice.chance(0.3) ? dice.between(-12.0, 12.0) * kDegree : 0.0;
  MachineSettings& m = scene.machine;
  m.speed_mps = dice.factor(4.0, 45.0);
  m.speed_sd_mps = dice.spread(0.03 * m.speed_mps);
  m.angle_rad = -dice.between(12.0, 80.0) * kDegree;
  m.angle_sd_rad = dice.spread(1.0 * kDegree);
  m.lag_sd_s = dice.factor(0.5e-3, 5e-3);
  m.spot_sd_m = dice.spread(0.012);
}

void draw_bounce(Dice& dice, Scene& scene) {
  BounceSettings& b = scene.bounce;
  b.contact = dice.chance(0.5) ? ContactLaw::ode : ContactLaw::grip;
  b.e = dice.between(0.35, 0.95);
  b.e_speed_mps = scene.machine.speed_mps * std::sin(-scene.machine.angle_rad);
  b.e_slope_spm = dice.chance(0.5) ? -0.017 : 0.0;
  b.e_sd = dice.spread(0.01);
  b.mu = dice.between(0.05, 0.9);
  b.mu_sd = dice.spread(0.03);
  b.dwell_s = dice.factor(1e-3, 8e-3);
  b.dwell_sd_s = dice.spread(0.04) * b.dwell_s;
  if (b.contact == ContactLaw::ode) {
    b.stiffness_ratio = dice.between(0.7, 2.0);
    b.damping_ratio = dice.between(0.05, 1.0);
    b.offset_share = dice.chance(0.2) ? 0.0 : dice.between(0.0, 0.25);
    b.offset_share_sd = dice.spread(0.02);
    b.stiffness_ratio_sd = dice.spread(0.05);
  } else {
    b.ex = dice.between(-0.2, 0.5);
    b.ex_sd = dice.spread(0.03);
    b.offset_m = dice.chance(0.2) ? 0.0 : dice.between(0.0, 0.006);
    b.offset_sd_m = dice.spread(0.0006);
    b.offset_grip_correlation = dice.between(-1.0, 1.0);
  }
}

void draw_air(Dice& dice, AirSettings& air) {
  air.temperature_c = dice.between(-10.0, 45.0);
  if (dice.chance(0.4)) air.density_kgpm3 = dice.chance(0.2) ? 0.0 : dice.between(0.2, 2.0);
  air.drag_coefficient = dice.chance(0.15) ? 0.0 : dice.between(0.1, 0.8);
  air.lift = dice.chance(0.8);
  air.spin_decay_per_m = dice.chance(0.2) ? 0.0 : dice.factor(1e-4, 0.05);
}

}  // namespace

RandomScene random_scene(std::uint64_t number) {
  Dice dice(number);
  RandomScene random;
  Scene& scene = random.scene;
  scene.name = fmt::format("random_{}", number);
  scene.title = scene.name;
  draw_shot_conditions(dice, scene);
  draw_bounce(dice, scene);
  draw_air(dice, scene.air);
  draw_bench(dice, scene);
  draw_camera(dice, scene);
  // A train that a lamp can follow, with some three to ten images of a leg within the view.
  const double images = dice.between(3.0, 10.0);
  const double reach_m =
      std::min(scene.camera.half_width_m, scene.camera.height_m / std::tan(-scene.machine.angle_rad));
  const double period_s = std::clamp(
      reach_m / (scene.machine.speed_mps * std::cos(scene.machine.angle_rad) * images), 0.6e-3, 8e-3);
  random.settings.period = nanoseconds(std::llround(period_s * 1e6) * 1000);
  random.settings.perfect_digitizer = true;
  // Spins that the train can read, and sometimes more.
  const double most_radps = std::numbers::pi / (2.0 * period_s);
  scene.machine.spin_radps = dice.between(-0.6, 0.6) * std::min(most_radps, 900.0);
  scene.machine.spin_sd_radps = dice.spread(0.02) * most_radps;
  return random;
}

std::string as_toml(const RandomScene& random) {
  const Scene& s = random.scene;
  const MachineSettings& m = s.machine;
  const BounceSettings& b = s.bounce;
  const CameraSettings& c = s.camera;
  std::string text = fmt::format(
      "# period_ms = {}\ntitle = \"{}\"\nsurface_angle_deg = {}\n[ball]\ndiameter_m = {}\nmass_kg = "
      "{}\nalpha "
      "= {}\n[machine]\nspeed_mps = {}\nspeed_sd_mps = {}\nangle_deg = {}\nangle_sd_deg = {}\nspin_radps = "
      "{}\nspin_sd_radps = {}\nlag_sd_ms = {}\nspot_sd_mm = {}\n",
      to_seconds(random.settings.period) * 1e3, s.title, s.surface_angle_rad / kDegree, s.ball.diameter_m,
      s.ball.mass_kg, s.ball.alpha, m.speed_mps, m.speed_sd_mps, m.angle_rad / kDegree,
      m.angle_sd_rad / kDegree, m.spin_radps, m.spin_sd_radps, m.lag_sd_s * 1e3, m.spot_sd_m * 1e3);
  text += fmt::format(
      "[bounce]\ne = {}\ne_speed_mps = {}\ne_slope_s_per_m = {}\ne_sd = {}\nmu = {}\nmu_sd = {}\ndwell_ms = "
      "{}\ndwell_sd_ms = {}\n",
      b.e, b.e_speed_mps, b.e_slope_spm, b.e_sd, b.mu, b.mu_sd, b.dwell_s * 1e3, b.dwell_sd_s * 1e3);
  if (b.contact == ContactLaw::ode) {
    text += fmt::format(
        "contact = \"ode\"\nstiffness_ratio = {}\nstiffness_ratio_sd = {}\ndamping_ratio = {}\noffset_share "
        "= {}\noffset_share_sd = {}\n",
        b.stiffness_ratio, b.stiffness_ratio_sd, b.damping_ratio, b.offset_share, b.offset_share_sd);
  } else {
    text += fmt::format(
        "contact = \"grip\"\nex = {}\nex_sd = {}\noffset_mm = {}\noffset_sd_mm = {}\n"
        "offset_grip_correlation = {}\n",
        b.ex, b.ex_sd, b.offset_m * 1e3, b.offset_sd_m * 1e3, b.offset_grip_correlation);
  }
  text += fmt::format(
      "[air]\ntemperature_c = {}\ndrag_coefficient = {}\nlift_law = \"{}\"\nspin_decay_per_m = {}\n",
      s.air.temperature_c, s.air.drag_coefficient, s.air.lift ? "spin_ratio" : "none",
      s.air.spin_decay_per_m);
  if (s.air.density_kgpm3 >= 0.0) text += fmt::format("density_kgpm3 = {}\n", s.air.density_kgpm3);
  text += fmt::format(
      "[lamps]\ndelay_us = {}\njitter_us = {}\nrecharge_us = {}\nflash_us = {}\n[sensors]\ndelay_us = "
      "{}\njitter_us = {}\n[shutter]\nlag_sd_ms = {}\n",
      s.lamps.delay_s * 1e6, s.lamps.jitter_s * 1e6, s.lamps.recharge_s * 1e6, s.lamps.flash_s * 1e6,
      s.sensors.delay_s * 1e6, s.sensors.jitter_s * 1e6, s.shutter.lag_sd_s * 1e3);
  text += fmt::format(
      "[camera]\npx_per_m = {}\nroll_deg = {}\nhalf_width_m = {}\nheight_m = {}\nmirrored = {}\ndistortion = "
      "{}\nrendering = \"{}\"\n",
      c.px_per_m, c.roll_rad / kDegree, c.half_width_m, c.height_m, c.mirrored, c.distortion,
      c.pixels ? "pixels" : "points");
  if (c.distance_m > 0.0)
    text += fmt::format("distance_m = {}\noff_plane_sd_mm = {}\n", c.distance_m, c.off_plane_sd_m * 1e3);
  text += fmt::format("[tablet]\ncentre_sd_mm = {}\nequator_sd_deg = {}\nvisible_flattening_mm = {}\n",
                      s.tablet.centre_sd_m * 1e3, s.tablet.equator_sd_rad / kDegree,
                      s.tablet.visible_flattening_m * 1e3);
  if (s.tablet.calibration_sd >= 0.0) text += fmt::format("calibration_sd = {}\n", s.tablet.calibration_sd);
  return text;
}

}  // namespace strobe::sim::test
