#include <algorithm>
#include <cmath>

#include "tests/contradictions/shot.hpp"

namespace strobe::contradictions {
namespace {

double off(double severity, Random& random) { return 1.0 + severity * random.sign(); }

double disturb_scale(Scene& scene, Random& random) {
  const double severity = random.logarithmic(0.005, 0.10);
  scene.told_px_per_m = scene.px_per_m * off(severity, random);
  scene.told_px_per_m_sd = 0.002 * *scene.told_px_per_m;
  // A tolerance of the ball that is wider would leave nothing to contradict.
  scene.told_diameter_sd_m.reset();
  scene.diameter_m = scene.told_diameter_m;
  if (random.chance(0.5)) {
    scene.told_diameter_sd_m = random.logarithmic(1e-4, 3e-4);
    scene.diameter_m += *scene.told_diameter_sd_m * random.normal();
  }
  return 100.0 * severity;
}

double disturb_ball(Scene& scene, bool calibrated, Random& random) {
  const double severity = random.logarithmic(0.01, 0.08);
  scene.told_diameter_sd_m.reset();
  if (random.chance(0.5)) scene.told_diameter_sd_m = random.logarithmic(1e-4, 3e-4);
  scene.diameter_m = scene.told_diameter_m * off(severity, random);
  scene.told_px_per_m.reset();
  scene.told_px_per_m_sd.reset();
  if (calibrated) {
    scene.told_px_per_m_sd = 0.002 * scene.px_per_m;
    scene.told_px_per_m = scene.px_per_m + *scene.told_px_per_m_sd * random.normal();
  }
  return 100.0 * severity;
}

double disturb_noise(Scene& scene, bool understated, Random& random) {
  const double ratio = random.logarithmic(1.0, 3.3);
  const double factor = understated ? ratio : 1.0 / ratio;
  Noise& f = scene.true_over_stated;
  double* const members[] = {&f.centre_px, &f.diameter_px, &f.equator_rad, &f.surface_px};
  if (random.chance(0.5)) {
    *members[random.index(4)] = factor;
  } else {
    for (double* member : members) *member = factor;
  }
  return ratio;
}

double disturb_alpha(Scene& scene, Random& random) {
  scene.told_alpha.reset();
  scene.alpha = random.within(0.51, 0.60);
  return std::abs(scene.alpha - 0.55);
}

/// Within what the reduction's README says of air and ball: no contradiction, what the sds must hold. Returns the drag
/// coefficient's deviation in its sd.
double draw_air(Scene& scene, Random& random) {
  const double severity = random.normal();
  scene.drag_coefficient = 0.55 + 0.05 * severity;
  scene.lift_factor = 1.0 + 0.2 * random.normal();
  scene.spin_decay_per_m = std::max(0.0, 0.01 + 0.005 * random.normal());
  const double thin_shell = 2.0 / 3.0;
  scene.alpha = std::min(scene.told_alpha_or_default() + 0.024 * random.normal(), thin_shell);
  return std::abs(severity);
}

double disturb_inclination(Scene& scene, Random& random) {
  const double severity = random.logarithmic(0.5, 15.0);
  scene.told_inclination_deg += severity * random.sign();
  return severity;
}

}  // namespace

double disturb_scene(Kind kind, Scene& scene, Random& random) {
  switch (kind) {
    case Kind::long_period:
      lengthen_period(scene, random);
      return 1e3 * scene.period_s;
    case Kind::surface_point:
      scene.surface_points = random.integer(3, 6);
      return 0.0;
    case Kind::surface_pair:
      scene.surface_points = 2;
      return 0.0;
    case Kind::scale:
      return disturb_scale(scene, random);
    case Kind::ball_size:
    case Kind::ball_size_uncalibrated:
      return disturb_ball(scene, kind == Kind::ball_size, random);
    case Kind::noise_understated:
    case Kind::noise_overstated:
      return disturb_noise(scene, kind == Kind::noise_understated, random);
    case Kind::heavy_tails:
      scene.heavy_tails = true;
      return 1.0;
    case Kind::alpha:
      return disturb_alpha(scene, random);
    case Kind::air:
      return draw_air(scene, random);
    case Kind::drag:
      scene.drag_coefficient = 0.55 * random.within(0.8, 1.2);
      return 100.0 * std::abs(scene.drag_coefficient / 0.55 - 1.0);
    case Kind::spin_decay:
      scene.spin_decay_per_m = random.within(0.005, 0.02);
      return 100.0 * scene.spin_decay_per_m;
    case Kind::surface_angle:
      return disturb_inclination(scene, random);
    case Kind::wrong_leg:
      scene.labels = true;
      return 0.0;
    default:
      return 0.0;
  }
}

}  // namespace strobe::contradictions
