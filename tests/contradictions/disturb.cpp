// Trouble of each kind, before the photograph is taken and in what was measured.
#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/contradictions/shot.hpp"

namespace strobe::contradictions {
namespace {

using reduction::BallImage;
using reduction::PointPx;

/// In standard deviations.
double drawn_severity(Random& random) { return random.logarithmic(1.0, 100.0); }

/// Airborne images of one leg, or of both.
std::vector<std::size_t> airborne(const Photograph& p, std::optional<Leg> leg = {}) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < p.legs.size(); ++i) {
    if (leg ? p.legs[i] == *leg : p.legs[i] != Leg::contact) found.push_back(i);
  }
  return found;
}

Leg either(Random& random) { return random.chance(0.5) ? Leg::incoming : Leg::rebound; }

void shift(PointPx& p, double distance_px, Random& random) {
  const double direction = random.within(0.0, 2.0 * kPi);
  p.x += distance_px * std::cos(direction);
  p.y += distance_px * std::sin(direction);
}

double worse(const BallImage& image, const Scene& scene) {
  return image.diameter_sd_px ? *image.diameter_sd_px / scene.stated.diameter_px : 1.0;
}

void shift_centre(Photograph& p, std::size_t i, double severity, const Scene& scene, Random& random) {
  BallImage& image = p.frame.images[i];
  shift(image.centre_px, severity * worse(image, scene) * scene.stated.centre_px, random);
}

void turn_equator(Photograph& p, std::size_t i, double severity, const Scene& scene, Random& random) {
  BallImage& image = p.frame.images[i];
  const double off_rad = random.sign() * severity * worse(image, scene) * scene.stated.equator_rad;
  // Another line on the ball may be taken for the equator.
  *image.equator_rad += random.chance(0.5) ? off_rad : random.within(-0.5 * kPi, 0.5 * kPi);
}

Disturbance off_surface(const Scene& scene, Photograph& p, Random& random) {
  const double severity = drawn_severity(random);
  const std::size_t index = random.index(p.frame.surface_px.size());
  PointPx& point = p.frame.surface_px[index];
  const double distance = random.sign() * severity * scene.stated.surface_px;
  point.x -= distance * std::sin(scene.tilt_rad);
  point.y += distance * std::cos(scene.tilt_rad);
  return {severity, index};
}

double off_diameter(const Scene& scene, Photograph& p, Random& random) {
  const double severity = drawn_severity(random);
  const auto images = airborne(p);
  BallImage& image = p.frame.images[images[random.index(images.size())]];
  const double off = severity * worse(image, scene) * scene.stated.diameter_px;
  // A diameter stays one.
  image.diameter_px = random.chance(0.5) ? image.diameter_px + off
                                         : std::max(image.diameter_px - off, 0.1 * image.diameter_px);
  return severity;
}

using Shift = void (*)(Photograph&, std::size_t, double, const Scene&, Random&);

Disturbance off_images(const Scene& scene, Photograph& p, std::size_t count, Shift shift_one,
                       Random& random) {
  auto images = airborne(p, either(random));
  const double severity = drawn_severity(random);
  const std::size_t first = images.front();
  for (std::size_t done = 0; done < count && !images.empty(); ++done) {
    const std::size_t k = random.index(images.size());
    shift_one(p, images[k], severity, scene, random);
    images.erase(images.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return {severity, first};
}

Disturbance off_first_image(const Scene& scene, Photograph& p, Random& random) {
  const double severity = drawn_severity(random);
  shift_centre(p, 0, severity, scene, random);
  return {severity, 0};
}

/// Neighbours of one leg that share a shift.
double share_shift(const Scene& scene, Photograph& p, Random& random) {
  const double severity = random.logarithmic(0.5, 5.0);
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    const auto images = airborne(p, leg);
    const auto together = static_cast<std::size_t>(random.integer(2, 4));
    double x = 0.0, y = 0.0;
    for (std::size_t k = 0; k < images.size(); ++k) {
      if (k % together == 0) {
        x = severity * scene.stated.centre_px * random.normal();
        y = severity * scene.stated.centre_px * random.normal();
      }
      p.frame.images[images[k]].centre_px.x += x;
      p.frame.images[images[k]].centre_px.y += y;
    }
  }
  return severity;
}

/// Moves a time by `by_s`, but never past a neighbour's.
void shift_time(std::vector<BallImage>& images, std::size_t i, double by_s) {
  constexpr double kCloser = 0.95;
  const double before = i > 0 ? images[i - 1].time_s - images[i].time_s : -1.0;
  const double after = i + 1 < images.size() ? images[i + 1].time_s - images[i].time_s : 1.0;
  images[i].time_s += std::clamp(by_s, kCloser * before, kCloser * after);
}

Disturbance off_time(const Scene& scene, Photograph& p, Random& random) {
  const auto images = airborne(p);
  const double share = random.logarithmic(0.01, 1.0);
  const std::size_t index = images[random.index(images.size())];
  shift_time(p.frame.images, index, random.sign() * share * scene.period_s);
  return {share, index};
}

double shake_times(const Scene& scene, Photograph& p, Random& random) {
  const double severity = random.logarithmic(0.3, 10.0);
  const double speed = std::hypot(scene.impact.vx_mps, scene.impact.vy_mps) * scene.px_per_m;
  const double sd_s = severity * scene.stated.centre_px / speed;
  for (std::size_t i = 0; i < p.frame.images.size(); ++i)
    shift_time(p.frame.images, i,
               std::clamp(sd_s * random.normal(), -0.4 * scene.period_s, 0.4 * scene.period_s));
  return severity;
}

double unread_equators(Photograph& p, Random& random) {
  const double share = random.within(0.05, 0.9);
  const bool pattern = random.chance(0.3);
  const std::size_t every = 2 + random.index(2);
  const std::size_t first = random.index(every);
  for (std::size_t i = 0; i < p.frame.images.size(); ++i) {
    const bool unread = pattern ? i % every != first : random.chance(share);
    if (unread) p.frame.images[i].equator_rad.reset();
  }
  return pattern ? 1.0 - 1.0 / static_cast<double>(every) : share;
}

Disturbance mislabel(Photograph& p, Random& random) {
  const std::size_t i = random.index(p.frame.images.size());
  const auto other = (static_cast<std::size_t>(p.legs[i]) + 1 + random.index(2)) % 3;
  p.frame.images[i].leg = static_cast<Leg>(other);
  return {1.0, i};
}

void remove(Photograph& p, const std::vector<bool>& missing) {
  std::vector<BallImage> images;
  std::vector<Leg> legs;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (missing[i]) continue;
    images.push_back(std::move(p.frame.images[i]));
    legs.push_back(p.legs[i]);
  }
  p.frame.images = std::move(images);
  p.legs = std::move(legs);
}

/// At least two images stay in each leg.
double make_gap(Photograph& p, Random& random) {
  const double share = random.within(0.05, 0.7);
  const bool row = random.chance(0.5);
  std::vector<bool> missing(p.frame.images.size(), false);
  for (const Leg leg : {Leg::incoming, Leg::rebound}) {
    auto images = airborne(p, leg);
    if (images.size() <= 2) continue;
    const auto most = static_cast<double>(images.size() - 2);
    const auto count =
        static_cast<std::size_t>(std::min(std::ceil(share * static_cast<double>(images.size())), most));
    const std::size_t first = random.index(images.size() - count + 1);
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t at = row ? first : random.index(images.size());
      missing[images[at]] = true;
      images.erase(images.begin() + static_cast<std::ptrdiff_t>(at));
    }
  }
  remove(p, missing);
  return share;
}

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

/// Of an axis up to 60 degrees off the camera's, no faster than what is told.
double tilt_axis(Scene& scene, bool measured, Random& random) {
  constexpr double kFarthest_rad = 60.0 * kDegree, kLineOut_sd_rad = 3.0 * kDegree;
  double farthest_rad = 0.0;
  const double omega[2] = {scene.impact.omega_radps, bounce(scene).lo.omega_radps};
  for (int leg = 0; leg < 2; ++leg) {
    double tilt_rad = random.within(0.0, kFarthest_rad);
    const double told = scene.told_fastest_spin_radps.value_or(1e9) * (leg == 0 ? 1.0 : 1.2);
    while (std::abs(omega[leg]) > told * std::cos(tilt_rad) && tilt_rad > 1e-3) tilt_rad *= 0.5;
    const double direction = random.within(0.0, 2.0 * kPi);
    scene.spin_x_ratio[leg] = std::tan(tilt_rad) * std::cos(direction);
    scene.spin_y_ratio[leg] = std::tan(tilt_rad) * std::sin(direction);
    farthest_rad = std::max(farthest_rad, tilt_rad);
  }
  scene.line_out_rad = kLineOut_sd_rad * random.normal();
  scene.line_measured = measured;
  return farthest_rad / kDegree;
}

double leave_plane(Scene& scene, Random& random) {
  const double aside_rad = random.within(-5.0, 5.0) * kDegree;
  scene.vz_mps[0] = std::tan(aside_rad) * scene.impact.vx_mps;
  scene.vz_mps[1] = random.within(0.4, 1.0) * scene.vz_mps[0];
  scene.lens_m = random.within(1.0, 3.0);
  scene.told_px_per_m_sd = 5e-4 * scene.px_per_m;
  scene.told_px_per_m = scene.px_per_m + *scene.told_px_per_m_sd * random.normal();
  return std::abs(aside_rad) / kDegree;
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
    case Kind::fast_spin:
    case Kind::fast_spin_coded:
      spin_fast(scene, kind == Kind::fast_spin_coded, random);
      return std::abs(scene.impact.omega_radps);
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
    case Kind::tilted_axis:
    case Kind::tilted_axis_unmeasured:
      return tilt_axis(scene, kind == Kind::tilted_axis, random);
    case Kind::off_plane:
      return leave_plane(scene, random);
    case Kind::wrong_leg:
      scene.labels = true;
      return 0.0;
    default:
      return 0.0;
  }
}

Disturbance disturb_measurements(Kind kind, const Scene& scene, Photograph& p, Random& random) {
  switch (kind) {
    case Kind::unread_equators:
      return {unread_equators(p, random)};
    case Kind::surface_point:
    case Kind::surface_pair:
      return off_surface(scene, p, random);
    case Kind::correlated:
      return {share_shift(scene, p, random)};
    case Kind::outlier_centre:
      return off_images(scene, p, 1, shift_centre, random);
    case Kind::two_centres:
      return off_images(scene, p, 2, shift_centre, random);
    case Kind::outlier_equator:
      return off_images(scene, p, 1, turn_equator, random);
    case Kind::two_equators:
      return off_images(scene, p, 2, turn_equator, random);
    case Kind::outlier_first_image:
      return off_first_image(scene, p, random);
    case Kind::outlier_diameter:
      return {off_diameter(scene, p, random)};
    case Kind::image_time:
      return off_time(scene, p, random);
    case Kind::time_noise:
      return {shake_times(scene, p, random)};
    case Kind::wrong_leg:
      return mislabel(p, random);
    case Kind::gap:
      return {make_gap(p, random)};
    default:
      return {};
  }
}

}  // namespace strobe::contradictions
