#include "tests/contradictions/shot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace strobe::contradictions {

Shot drawn_shot(Kind kind, const Settings& settings, std::uint64_t seed, std::uint64_t number) {
  Random random(seed, static_cast<std::uint64_t>(kind), number);
  Scene scene = drawn_scene(settings, random);
  Shot shot;
  shot.kind = kind;
  const double before = disturb_scene(kind, scene, random);
  shot.photograph = photograph(scene, random);
  shot.photograph.frame.shot_id = static_cast<int>(number % 1'000'000'000U);
  const Disturbance after = disturb_measurements(kind, scene, shot.photograph, random);
  shot.severity = std::max(before, after.severity);
  const Disturbance whole{shot.severity, after.index};
  shot.proof_sd = proof_sd(kind, scene, shot.photograph, whole);
  shot.few = among_few(kind, shot.photograph, whole);
  return shot;
}

namespace {

/// Calibrated scale against the mean of the airborne diameters over the ball's.
double of_scale(const Scene& scene, const Photograph& p, double percent) {
  const auto airborne =
      std::count_if(p.legs.begin(), p.legs.end(), [](Leg leg) { return leg != Leg::contact; });
  const double calibration = *scene.told_px_per_m_sd / *scene.told_px_per_m;
  const double ball = scene.told_diameter_sd_m.value_or(0.0) / scene.told_diameter_m;
  const double image = scene.stated.diameter_px / (scene.px_per_m * scene.diameter_m);
  const double mean = image / std::sqrt(static_cast<double>(airborne));
  return 0.01 * percent / std::hypot(calibration, ball, mean);
}

/// A point's residual keeps 1 - h of its shift, h being its leverage in the line through all points.
double of_surface_point(const Scene& scene, const Photograph& p, const Disturbance& d) {
  const auto& points = p.frame.surface_px;
  const double n = static_cast<double>(points.size());
  const auto along = [&](const reduction::PointPx& q) {
    return q.x * std::cos(scene.tilt_rad) + q.y * std::sin(scene.tilt_rad);
  };
  double mean = 0.0, square = 0.0;
  for (const auto& q : points) mean += along(q) / n;
  for (const auto& q : points) square += (along(q) - mean) * (along(q) - mean);
  const double x = along(points[d.index]) - mean;
  return d.severity * std::sqrt(std::max(0.0, 1.0 - 1.0 / n - x * x / square));
}

/// Residual sum of squares of t^2 / 2 over a leg's images after a straight line.
double curvature_square(const Photograph& p, Leg leg) {
  double n = 0.0, t1 = 0.0, y1 = 0.0, origin = 0.0;
  for (std::size_t i = 0; i < p.legs.size(); ++i) {
    if (p.legs[i] != leg) continue;
    if (n == 0.0) origin = p.frame.images[i].time_s;
    const double t = p.frame.images[i].time_s - origin;
    n += 1.0, t1 += t, y1 += 0.5 * t * t;
  }
  double tt = 0.0, ty = 0.0, yy = 0.0;
  for (std::size_t i = 0; i < p.legs.size(); ++i) {
    if (p.legs[i] != leg) continue;
    const double from = p.frame.images[i].time_s - origin;
    const double t = from - t1 / n, y = 0.5 * from * from - y1 / n;
    tt += t * t, ty += t * y, yy += y * y;
  }
  return tt > 0.0 ? std::max(0.0, yy - ty * ty / tt) : 0.0;
}

/// Gravity in a wrong direction bends both legs.
double of_surface_angle(const Scene& scene, const Photograph& p, double degrees) {
  const double change_mps2 = 2.0 * 9.80665 * std::sin(0.5 * degrees * kDegree);
  const double speed = std::hypot(scene.impact.vx_mps, scene.impact.vy_mps);
  const double noise_m = std::hypot(scene.stated.centre_px / scene.px_per_m, speed * scene.time_sd_s);
  const double square = curvature_square(p, Leg::incoming) + curvature_square(p, Leg::rebound);
  return change_mps2 * std::sqrt(square) / noise_m;
}

}  // namespace

double proof_sd(Kind kind, const Scene& scene, const Photograph& photograph, const Disturbance& disturbance) {
  switch (kind) {
    case Kind::surface_pair:
    case Kind::ball_size_uncalibrated:
      return 0.0;
    case Kind::scale:
    case Kind::ball_size:
      return of_scale(scene, photograph, disturbance.severity);
    case Kind::surface_point:
      return of_surface_point(scene, photograph, disturbance);
    case Kind::surface_angle:
      return of_surface_angle(scene, photograph, disturbance.severity);
    default:
      return std::numeric_limits<double>::infinity();
  }
}

bool among_few(Kind kind, const Photograph& photograph, const Disturbance& disturbance) {
  constexpr std::size_t kEnoughPoints = 4;
  // Of five, one may be so near the surface that it is taken for an image in contact.
  constexpr std::ptrdiff_t kEnoughImages = 5;
  const auto images = [&](Leg leg) {
    return std::count(photograph.legs.begin(), photograph.legs.end(), leg);
  };
  switch (kind) {
    case Kind::surface_point:
    case Kind::surface_pair:
      return photograph.frame.surface_px.size() < kEnoughPoints;
    case Kind::outlier_centre:
    case Kind::outlier_first_image:
    case Kind::outlier_equator:
    case Kind::two_equators:
    case Kind::two_centres:
    case Kind::image_time:
    case Kind::wrong_leg:
      return images(photograph.legs[disturbance.index]) < kEnoughImages;
    case Kind::noise_understated:
    case Kind::heavy_tails:
    case Kind::correlated:
    case Kind::time_noise:
      return std::min(images(Leg::incoming), images(Leg::rebound)) < kEnoughImages;
    default:
      return false;
  }
}

}  // namespace strobe::contradictions
