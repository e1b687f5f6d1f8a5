#include "tests/contradictions/scene.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::contradictions {
namespace {

constexpr double kGravity_mps2 = 9.80665;

double density(const Scene& scene) { return 1.204 * 293.15 / (273.15 + scene.temperature_c); }

void draw_ball(Scene& scene, Random& random) {
  scene.told_diameter_m = scene.diameter_m = random.within(0.0635, 0.0686);
  if (random.chance(0.5)) {
    scene.told_diameter_sd_m = random.logarithmic(1e-4, 1e-3);
    scene.diameter_m += *scene.told_diameter_sd_m * random.normal();
  }
  scene.mass_kg = 0.0576;
  if (random.chance(0.5)) scene.told_alpha = random.within(0.50, 0.62);
  scene.alpha = scene.told_alpha_or_default();
}

void draw_temperature(Scene& scene, Random& random) {
  scene.temperature_c = random.within(5.0, 35.0);
  scene.tell_temperature = random.chance(0.7);
  if (!scene.tell_temperature) scene.temperature_c = 20.0;
}

void draw_impact(ImpactParameters& impact, Random& random) {
  const double angle = random.within(12.0, 80.0) * kDegree;
  const double speed = std::max(random.within(5.0, 35.0), 2.0 / std::sin(angle));
  impact.vx_mps = speed * std::cos(angle);
  impact.vy_mps = -speed * std::sin(angle);
  impact.omega_radps = random.chance(0.1) ? 0.0 : random.within(-400.0, 400.0);
  impact.e = random.within(0.55, 0.9);
  impact.mu = random.within(0.3, 0.8);
  // A third of the gripping ones roll exactly, as models that know no more have it.
  if (random.chance(2.0 / 3.0)) {
    impact.e_x = random.within(0.0, 0.2);
    impact.offset_m = random.within(0.0, 3e-3);
  }
  impact.dwell_s = random.within(3.5e-3, 6e-3);
  impact.path_factor = random.within(0.9, 1.1);
}

void draw_camera(Scene& scene, Random& random) {
  scene.px_per_m = random.within(1500.0, 4000.0);
  scene.tilt_rad = (random.chance(0.7) ? random.within(-3.0, 3.0) : random.within(-40.0, 40.0)) * kDegree;
  scene.to_the_left = random.chance(0.4);
  scene.surface_points = random.integer(2, 6);
  if (random.chance(0.5)) scene.inclination_deg = random.within(-20.0, 20.0);
  scene.told_inclination_deg = scene.inclination_deg;
  if (random.chance(0.5)) return;
  scene.told_px_per_m = scene.px_per_m;
  if (random.chance(0.1)) return;  // exact
  scene.told_px_per_m_sd = scene.px_per_m * random.logarithmic(1e-3, 1e-2);
  *scene.told_px_per_m += *scene.told_px_per_m_sd * random.normal();
}

Noise drawn_noise(NoiseLevel level, Random& random) {
  Noise noise;
  const bool hand = level == NoiseLevel::hand;
  noise.centre_px = hand ? random.logarithmic(0.5, 2.0) : random.within(0.05, 0.1);
  noise.diameter_px = noise.centre_px * random.within(0.8, 1.5);
  noise.equator_rad = hand ? random.logarithmic(0.7, 2.0) * kDegree : random.within(0.1, 0.3) * kDegree;
  noise.surface_px = random.chance(0.5) ? noise.centre_px : noise.centre_px * random.within(0.5, 2.0);
  return noise;
}

/// Coded intervals differ by up to a fifth: see photograph.cpp.
double resolved_period_s(const Scene& scene) {
  const Bounce b = bounce(scene);
  const double fastest = std::max({std::abs(b.td.omega_radps), std::abs(b.lo.omega_radps), 1.0});
  return 0.8 * kPi / (2.0 * 1.2 * fastest);
}

constexpr double kLongestStep_s = 2e-3;

/// The motion's derivative by time, member by member.
Motion rate(const Motion& m, const Forces& f) {
  const double speed = std::sqrt(m.vx_mps * m.vx_mps + m.vy_mps * m.vy_mps);
  const double rim = f.radius_m * m.omega_radps;
  const double lift = speed > 0.0 ? f.lift_per_m * rim / (2.0 * std::abs(rim) + speed) * speed : 0.0;
  const double drag = f.drag_per_m * speed;
  return {.x_m = m.vx_mps,
          .y_m = m.vy_mps,
          .vx_mps = f.gx_mps2 - drag * m.vx_mps - lift * m.vy_mps,
          .vy_mps = f.gy_mps2 - drag * m.vy_mps + lift * m.vx_mps,
          .angle_rad = m.omega_radps,
          .omega_radps = -f.decay_per_m * speed * m.omega_radps};
}

Motion moved(const Motion& m, const Motion& rate, double h) {
  return {m.x_m + h * rate.x_m,
          m.y_m + h * rate.y_m,
          m.vx_mps + h * rate.vx_mps,
          m.vy_mps + h * rate.vy_mps,
          m.angle_rad + h * rate.angle_rad,
          m.omega_radps + h * rate.omega_radps};
}

Motion step(const Motion& m, const Forces& f, double h) {
  const Motion a = rate(m, f);
  const Motion b = rate(moved(m, a, 0.5 * h), f);
  const Motion c = rate(moved(m, b, 0.5 * h), f);
  const Motion d = rate(moved(m, c, h), f);
  return moved(moved(moved(moved(m, a, h / 6.0), b, h / 3.0), c, h / 3.0), d, h / 6.0);
}

}  // namespace

Bounce bounce(const Scene& scene) {
  const ImpactParameters& p = scene.impact;
  const double r = scene.radius_m();
  const double impulse = (1.0 + p.e) * std::abs(p.vy_mps);  // per mass
  // Ahead of the centre, in the direction of travel: turns a ball that moves along +x counter-clockwise.
  const double turn = p.offset_m * impulse / (scene.alpha * r);
  const double slip = p.vx_mps + r * p.omega_radps;
  const double gripping = -((1.0 + p.e_x) * slip + turn) / (1.0 + 1.0 / scene.alpha);
  const double limit = p.mu * impulse;
  const double change = std::clamp(gripping, -limit, limit);
  Bounce b;
  b.slid = change != gripping;
  b.td = {0.0, r, p.vx_mps, p.vy_mps, 0.0, p.omega_radps};
  b.lo = {0.0, r, p.vx_mps + change, -p.e * p.vy_mps, 0.0, p.omega_radps + (change / scene.alpha + turn) / r};
  b.lo.x_m = p.path_factor * p.dwell_s * 0.5 * (b.td.vx_mps + b.lo.vx_mps);
  b.lo.angle_rad = p.dwell_s * 0.5 * (b.td.omega_radps + b.lo.omega_radps);
  return b;
}

Forces forces(const Scene& scene) {
  const double area = kPi * scene.radius_m() * scene.radius_m();
  const double lift = density(scene) * area / (2.0 * scene.mass_kg);
  // The plate's inclination turns gravity the other way; a ball to the left sees it mirrored.
  const double inclination = scene.inclination_deg * kDegree * (scene.to_the_left ? -1.0 : 1.0);
  return {.gx_mps2 = -kGravity_mps2 * std::sin(inclination),
          .gy_mps2 = -kGravity_mps2 * std::cos(inclination),
          .drag_per_m = lift * scene.drag_coefficient,
          .lift_per_m = lift * scene.lift_factor,
          .decay_per_m = scene.spin_decay_per_m * density(scene) / 1.204,
          .radius_m = scene.radius_m()};
}

Scene drawn_scene(const Settings& settings, Random& random) {
  Scene scene;
  draw_ball(scene, random);
  draw_impact(scene.impact, random);
  draw_camera(scene, random);
  draw_temperature(scene, random);
  scene.coded = random.chance(0.3);
  scene.period_s = std::min(random.within(1e-3, 4e-3), resolved_period_s(scene));
  const double least = settings.least_images, most = settings.most_images + 1.0;
  scene.incoming = static_cast<int>(random.logarithmic(least, most));
  scene.rebound = static_cast<int>(random.logarithmic(least, most));
  scene.labels = random.chance(0.5);
  scene.contact_images = random.chance(0.75);
  scene.noise_stated = settings.noise_stated;
  scene.noise_by_image = scene.noise_stated && random.chance(0.2);
  scene.stated = drawn_noise(settings.noise, random);
  scene.flash_indices = random.chance(0.5);
  if (random.chance(0.2)) scene.time_sd_s = random.logarithmic(1e-6, 2e-5);
  return scene;
}

void lengthen_period(Scene& scene, Random& random) {
  scene.impact.omega_radps = random.within(-600.0, 600.0);
  scene.period_s = random.within(5e-3, 15e-3);
}

void spin_fast(Scene& scene, bool coded, Random& random) {
  scene.impact.omega_radps = random.within(-1500.0, 1500.0);
  scene.told_fastest_spin_radps.reset();
  scene.coded = coded;
  scene.period_s = random.within(1e-3, 6e-3);
}

Motion flown(const Motion& from, const Forces& forces, double duration_s) {
  const double steps = std::ceil(std::abs(duration_s) / kLongestStep_s);
  const int count = steps < 1.0 ? 1 : static_cast<int>(steps);
  Motion motion = from;
  for (int i = 0; i < count; ++i) motion = step(motion, forces, duration_s / count);
  return motion;
}

}  // namespace strobe::contradictions
