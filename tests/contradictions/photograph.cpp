#include "tests/contradictions/photograph.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace strobe::contradictions {
namespace {

using reduction::BallImage;
using reduction::Frame;
using reduction::PointPx;
using reduction::Quantity;

/// Of a leg: what a photograph shows at some 3 px a millimetre.
constexpr double kField_m = 1.2;
/// Coded intervals differ from the period by up to this share.
constexpr double kCode = 0.2;

struct Instant {
  double time_s = 0.0;  ///< from touchdown
  int flash = 0;
  Leg leg = Leg::incoming;
  Motion motion;
};

double interval_s(const Scene& scene, Random& random) {
  return scene.coded ? scene.period_s * random.within(1.0 - kCode, 1.0 + kCode) : scene.period_s;
}

/// Too far away, or so slow towards the surface that the leg was no longer (not yet) one flight.
bool leaves_the_scene(const Motion& now, const Motion& at_surface) {
  const double x = now.x_m - at_surface.x_m, y = now.y_m - at_surface.y_m;
  return x * x + y * y > kField_m * kField_m || now.vy_mps / at_surface.vy_mps < 0.3;
}

/// Images of a leg from the surface outwards, `first_s` from it and `direction` in time.
void fly(const Scene& scene, const Motion& at_surface, double from_s, double first_s, bool before,
         std::vector<Instant>& instants, Random& random) {
  const Forces f = forces(scene);
  const double direction = before ? -1.0 : 1.0;
  const int count = before ? scene.incoming : scene.rebound;
  Motion motion = at_surface;
  double from_surface_s = 0.0, next_s = first_s;
  for (int i = 0; i < count; ++i) {
    motion = flown(motion, f, direction * (next_s - from_surface_s));
    from_surface_s = next_s;
    if (i >= 2 && leaves_the_scene(motion, at_surface)) return;
    instants.push_back(
        {from_s + direction * from_surface_s, 0, before ? Leg::incoming : Leg::rebound, motion});
    next_s += interval_s(scene, random);
  }
}

/// Half a sine of vertical squash, along the surface and in angle even.
Motion in_contact(const Scene& scene, const Bounce& b, double time_s) {
  const double share = time_s / scene.impact.dwell_s;
  const double depth = -b.td.vy_mps * scene.impact.dwell_s / kPi * std::sin(kPi * share);
  return {.x_m = share * b.lo.x_m,
          .y_m = scene.radius_m() - std::min(depth, 0.8 * scene.radius_m()),
          .vx_mps = 0.0,
          .vy_mps = 0.0,
          .angle_rad = share * b.lo.angle_rad,
          .omega_radps = 0.0};
}

std::vector<Instant> instants(const Scene& scene, Random& random) {
  const Bounce b = bounce(scene);
  std::vector<Instant> all;
  const double phase_s = scene.period_s * random.uniform();
  fly(scene, b.td, 0.0, phase_s, true, all, random);
  std::reverse(all.begin(), all.end());
  int flash = 0;
  for (Instant& instant : all) instant.flash = flash++;
  double next_s = interval_s(scene, random) - phase_s;
  while (next_s < 0.0) next_s += scene.period_s;
  for (; next_s < scene.impact.dwell_s; next_s += interval_s(scene, random), ++flash) {
    if (scene.contact_images) all.push_back({next_s, flash, Leg::contact, in_contact(scene, b, next_s)});
  }
  const std::size_t before = all.size();
  fly(scene, b.lo, scene.impact.dwell_s, next_s - scene.impact.dwell_s, false, all, random);
  for (std::size_t i = before; i < all.size(); ++i) all[i].flash = flash++;
  return all;
}

class Camera {
 public:
  explicit Camera(const Scene& scene)
      : px_per_m_(scene.px_per_m),
        cos_(std::cos(scene.tilt_rad)),
        sin_(std::sin(scene.tilt_rad)),
        tilt_rad_(scene.tilt_rad),
        side_(scene.to_the_left ? -1.0 : 1.0) {}

  PointPx place(double x_m, double y_m) const {
    const double x = side_ * px_per_m_ * x_m, y = px_per_m_ * y_m;
    return {1500.0 + cos_ * x - sin_ * y, 600.0 + sin_ * x + cos_ * y};
  }
  double angle(double rad) const { return tilt_rad_ + side_ * rad; }
  /// The normal of a plane, in axes of the photograph.
  Eigen::Vector3d normal(const Eigen::Vector3d& n) const {
    const double x = side_ * n.x();
    return {cos_ * x - sin_ * n.y(), sin_ * x + cos_ * n.y(), n.z()};
  }

 private:
  double px_per_m_, cos_, sin_, tilt_rad_, side_;
};

double noise(const Scene& scene, Random& random) {
  // Of the same variance.
  return scene.heavy_tails ? random.student_3() / std::sqrt(3.0) : random.normal();
}

PointPx shaken(const PointPx& p, double sd_px, const Scene& scene, Random& random) {
  const double x = sd_px * noise(scene, random);
  return {p.x + x, p.y + sd_px * noise(scene, random)};
}

double wrapped_half_turn(double angle) { return angle - kPi * std::floor(angle / kPi + 0.5); }

BallImage digitized(const Scene& scene, const Camera& camera, const Instant& instant, Random& random) {
  // Some images are read worse than others, and said to be.
  const double worse = scene.noise_by_image ? random.within(0.7, 1.5) : 1.0;
  const Noise& s = scene.stated;
  const Noise& f = scene.true_over_stated;
  const Motion& m = instant.motion;
  BallImage image;
  image.centre_px = shaken(camera.place(m.x_m, m.y_m), worse * s.centre_px * f.centre_px, scene, random);
  image.diameter_px =
      scene.px_per_m * scene.diameter_m + worse * s.diameter_px * f.diameter_px * noise(scene, random);
  const double angle =
      camera.angle(m.angle_rad) + worse * s.equator_rad * f.equator_rad * noise(scene, random);
  image.equator_rad = wrapped_half_turn(angle);
  if (scene.labels) image.leg = instant.leg;
  if (!scene.noise_by_image) return image;
  const double variance = worse * worse * s.centre_px * s.centre_px;
  image.centre_cov_px2 = {variance, 0.0, 0.0, variance};
  image.diameter_sd_px = worse * s.diameter_px;
  image.equator_sd_rad = worse * s.equator_rad;
  return image;
}

/// The line of a ball that spins about another axis, in the place of the equator: the chord between its ends on the
/// outline, and how far its plane is tilted out of the line of sight.
void draw_line(const Scene& scene, const Camera& camera, const Instant& instant, const Bounce& b, double phase_rad,
               BallImage& image, Random& random) {
  const std::size_t leg = instant.leg == Leg::rebound ? 1 : 0;
  const Motion& surface = leg == 0 ? b.td : b.lo;
  const double turned_rad = instant.motion.angle_rad - phase_rad - surface.angle_rad;
  const Eigen::Vector3d axis(scene.spin_x_ratio[leg], scene.spin_y_ratio[leg], 1.0);
  const double start_rad = phase_rad + surface.angle_rad;
  const Eigen::Vector3d drawn(-std::sin(start_rad) * std::cos(scene.line_out_rad),
                              std::cos(start_rad) * std::cos(scene.line_out_rad), -std::sin(scene.line_out_rad));
  const Eigen::Vector3d n =
      camera.normal(Eigen::AngleAxisd(turned_rad * axis.norm(), axis.normalized()) * drawn);
  const double tilt = -std::asin(n.z());
  const double worse = image.equator_sd_rad.value_or(scene.stated.equator_rad);
  const double factor = scene.true_over_stated.equator_rad;
  // A line that becomes a ring tells its chord worse.
  const double angle_sd = worse / std::max(std::cos(tilt), 0.2), tilt_sd = 1.5 * worse;
  const double angle = std::atan2(-n.x(), n.y()) + factor * angle_sd * noise(scene, random);
  const double wrapped = wrapped_half_turn(angle), read = tilt + factor * tilt_sd * noise(scene, random);
  image.equator_rad = wrapped;
  image.equator_sd_rad = angle_sd;
  if (!scene.line_measured) return;
  const bool turned = std::fmod(std::abs(std::round((angle - wrapped) / kPi)), 2.0) == 1.0;
  image.equator_tilt_rad = std::clamp(turned ? -read : read, -0.5 * kPi, 0.5 * kPi);
  image.equator_tilt_sd_rad = tilt_sd;
}

/// What the lens makes of a ball that is nearer than the plane.
void see_in_perspective(const Scene& scene, const Instant& instant, const PointPx& foot, BallImage& image) {
  // Slower and slower during the contact: the mean of both, from its middle on.
  const double middle_s = 0.5 * scene.impact.dwell_s, since_s = instant.time_s - middle_s;
  const double vz = instant.leg == Leg::contact ? 0.5 * (scene.vz_mps[0] + scene.vz_mps[1])
                                               : scene.vz_mps[instant.leg == Leg::rebound ? 1 : 0];
  const double half_s = instant.leg == Leg::contact ? 0.0 : std::copysign(middle_s, since_s);
  const double mean = 0.5 * (scene.vz_mps[0] + scene.vz_mps[1]);
  const double grown = 1.0 / (1.0 - (mean * half_s + vz * (since_s - half_s)) / scene.lens_m);
  image.centre_px.x = foot.x + grown * (image.centre_px.x - foot.x);
  image.centre_px.y = foot.y + grown * (image.centre_px.y - foot.y);
  image.diameter_px *= grown;
}

/// Spread over both sides of the impact.
void add_surface(const Scene& scene, const Camera& camera, Frame& frame, Random& random) {
  const double half_m = random.within(0.15, 0.5);
  const double sd = scene.stated.surface_px * scene.true_over_stated.surface_px;
  for (int i = 0; i < scene.surface_points; ++i) {
    const double place = (i + random.within(0.2, 0.8)) / scene.surface_points;
    frame.surface_px.push_back(shaken(camera.place(half_m * (2.0 * place - 1.0), 0.0), sd, scene, random));
  }
}

void tell(const Scene& scene, Frame& frame) {
  frame.ball_diameter_m = scene.told_diameter_m;
  frame.ball_diameter_sd_m = scene.told_diameter_sd_m;
  frame.ball_alpha = scene.told_alpha;
  frame.fastest_spin_radps = scene.told_fastest_spin_radps;
  frame.px_per_m = scene.told_px_per_m;
  frame.px_per_m_sd = scene.told_px_per_m_sd;
  frame.surface_angle_deg = scene.told_inclination_deg;
  if (scene.tell_temperature) frame.temperature_c = scene.temperature_c;
  if (!scene.noise_stated) return;
  frame.surface_sd_px = scene.stated.surface_px;
  frame.centre_sd_px = scene.stated.centre_px;
  frame.diameter_sd_px = scene.stated.diameter_px;
  frame.equator_sd_rad = scene.stated.equator_rad;
}

}  // namespace

Truth truth(const Scene& scene) {
  const Bounce b = bounce(scene);
  Truth t;
  const auto put = [&](Quantity q, double value) { t.value[q] = value; };
  const double e = -b.lo.vy_mps / b.td.vy_mps;
  const double mu = (b.td.vx_mps - b.lo.vx_mps) / (b.lo.vy_mps - b.td.vy_mps);
  put(Quantity::theta_in_deg, std::atan2(b.td.vy_mps, b.td.vx_mps) * 180.0 / kPi);
  put(Quantity::theta_out_deg, std::atan2(b.lo.vy_mps, b.lo.vx_mps) * 180.0 / kPi);
  put(Quantity::vx_td_mps, b.td.vx_mps);
  put(Quantity::vy_td_mps, b.td.vy_mps);
  put(Quantity::v_td_mps, std::hypot(b.td.vx_mps, b.td.vy_mps));
  put(Quantity::omega_td_radps, b.td.omega_radps);
  put(Quantity::vx_lo_mps, b.lo.vx_mps);
  put(Quantity::vy_lo_mps, b.lo.vy_mps);
  put(Quantity::v_lo_mps, std::hypot(b.lo.vx_mps, b.lo.vy_mps));
  put(Quantity::omega_lo_radps, b.lo.omega_radps);
  put(Quantity::slip_lo_mps, b.lo.vx_mps + scene.radius_m() * b.lo.omega_radps);
  put(Quantity::e, e);
  put(Quantity::mu, mu);
  put(Quantity::dwell_time_ms, 1e3 * scene.impact.dwell_s);
  put(Quantity::dwell_distance_cm, 1e2 * b.lo.x_m);
  // ITF CS 01/02.
  put(Quantity::court_pace, 100.0 * (1.0 - mu) + 150.0 * (0.81 - (e + 0.003 * (23.0 - scene.temperature_c))));
  t.mirrored = scene.to_the_left;
  t.slid = b.slid;
  const double slip = b.td.vx_mps + scene.radius_m() * b.td.omega_radps;
  t.missing_mps = std::abs(slip) * scene.alpha / (1.0 + scene.alpha) - std::abs(b.td.vx_mps - b.lo.vx_mps);
  t.alpha = scene.alpha;
  t.radius_m = scene.radius_m();
  return t;
}

Photograph photograph(const Scene& scene, Random& random) {
  Photograph p;
  p.truth = truth(scene);
  tell(scene, p.frame);
  const Camera camera(scene);
  const double origin_s = random.within(0.0, 2.0);
  const double phase_rad = random.within(0.0, kPi);
  add_surface(scene, camera, p.frame, random);
  const Bounce b = bounce(scene);
  const bool tilted = scene.spin_x_ratio[0] != 0.0;
  const PointPx foot = camera.place(0.05, 0.15);
  if (scene.lens_m > 0.0) p.frame.lens = {scene.lens_m, foot};
  for (Instant& instant : instants(scene, random)) {
    instant.motion.angle_rad += phase_rad;
    BallImage image = digitized(scene, camera, instant, random);
    if (tilted && instant.leg != Leg::contact) draw_line(scene, camera, instant, b, phase_rad, image, random);
    if (scene.lens_m > 0.0) see_in_perspective(scene, instant, foot, image);
    image.time_s = origin_s + instant.time_s + scene.time_sd_s * random.normal();
    if (scene.time_sd_s > 0.0) image.time_sd_s = scene.time_sd_s;
    if (scene.flash_indices) image.flash_index = instant.flash;
    p.frame.images.push_back(std::move(image));
    p.legs.push_back(instant.leg);
  }
  return p;
}

}  // namespace strobe::contradictions
