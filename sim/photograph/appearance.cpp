#include "sim/photograph/appearance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr double kMilli = 1e-3;
constexpr double kTiltSd_rad = 1.5 * std::numbers::pi / 180.0;
constexpr double kMaxTilt_rad = 5.0 * std::numbers::pi / 180.0;

/// Draws in a fixed order; `given` overrides what was drawn.
class Artist {
 public:
  explicit Artist(Draws draws) : draws_(draws) {}
  double between(double least, double most, const std::optional<double>& given = {}) {
    return given.value_or(least + (most - least) * draws_.uniform());
  }
  /// Of evenly spread logarithm.
  double scaled(double least, double most, const std::optional<double>& given = {}) {
    const double drawn = least * std::pow(most / least, draws_.uniform());
    return given.value_or(drawn);
  }
  double normal(double sd, double most, const std::optional<double>& given = {}) {
    const double drawn = std::clamp(sd * draws_.normal(), -most, most);
    return given.value_or(drawn);
  }
  std::uint64_t seed() { return static_cast<std::uint64_t>(draws_.uniform() * 0x1p53); }

 private:
  Draws draws_;
};

/// Of a surface without felt: albedo, share of the drawn gloss, and the range of its markings' contrast.
struct Finish {
  double albedo = 1.0, gloss = 0.0, least_contrast = 0.0, most_contrast = 0.0;
};

Finish finish_of(BallSurface surface) {
  switch (surface) {
    case BallSurface::felt:
    case BallSurface::plain:
      break;
    case BallSurface::dimples:
      return {1.0, 1.0, 0.0, 0.0};
    case BallSurface::stitches:
      return {1.0, 0.3, 0.3, 0.8};
    case BallSurface::band:
      return {0.35, 1.0, -1.5, -0.6};
    case BallSurface::panels:
      return {1.0, 0.8, 0.3, 0.9};
    case BallSurface::channels:
      return {0.55, 0.2, 0.5, 0.9};
    case BallSurface::holes:
      return {1.0, 0.4, 0.5, 0.9};
    case BallSurface::dots:
      return {1.0, 0.3, 0.6, 0.95};
  }
  return {};
}

BallAppearance draw_ball(Artist& artist, const BallAppearanceSettings& s) {
  BallAppearance b;
  b.surface = s.surface;
  b.line = s.line;
  b.line_width_m = artist.between(1.5 * kMilli, 4.0 * kMilli, s.line_width_m);
  b.line_contrast = artist.between(0.5, 0.95, s.line_contrast);
  b.line_steepness = artist.scaled(2.0, 10.0);
  b.line_tilt_rad = artist.normal(kTiltSd_rad, kMaxTilt_rad, s.line_tilt_rad);
  b.line_offset = s.line_offset;
  b.grain = artist.between(0.02, 0.1, s.grain);
  const double seam = artist.between(-0.3, 0.4);
  b.seam_contrast = s.seam_contrast.value_or(seam);
  b.logo_contrast = artist.between(0.0, 0.8, s.logo_contrast);
  b.fuzz_px = artist.between(0.0, 0.5, s.fuzz_px);
  b.hair_px = artist.between(0.0, 0.2);
  b.falloff = artist.between(0.55, 1.1);
  b.sheen = artist.between(0.0, 0.35);
  b.shine = artist.between(0.1, 0.6);
  b.texture = artist.seed();
  const Finish finish = finish_of(b.surface);
  b.albedo = s.albedo.value_or(finish.albedo);
  b.shine = s.shine.value_or(finish.gloss * b.shine) / b.albedo;
  if (b.surface == BallSurface::felt) return b;
  b.fuzz_px = s.fuzz_px.value_or(0.0);
  b.hair_px = 0.0;
  b.sheen = 0.0;
  b.grain = s.grain.value_or(0.0);
  // The felt's draw, in this surface's range.
  const double contrast =
      finish.least_contrast + (finish.most_contrast - finish.least_contrast) * (seam + 0.3) / 0.7;
  b.seam_contrast = s.seam_contrast.value_or(contrast);
  if (b.surface == BallSurface::plain) b.logo_contrast = s.logo_contrast.value_or(0.0);
  return b;
}

LampAppearance draw_lamp(Artist& artist, const BallAppearanceSettings& s, double side, double power) {
  LampAppearance lamp;
  lamp.place.x = side * artist.between(0.5, 1.6, s.lamp_aside_m);
  lamp.place.y = artist.between(-0.2, 0.8, s.lamp_height_m);
  lamp.place.z = artist.between(0.5, 2.0, s.lamp_forward_m);
  lamp.power = power * artist.between(0.8, 1.2);
  lamp.radius_m = artist.between(0.02, 0.1);
  return lamp;
}

Appearance draw(const Scene& scene, std::uint64_t seed, int shot) {
  Artist artist(Draws(seed, Purpose::appearance, static_cast<std::uint64_t>(shot)));
  Appearance appearance;
  appearance.ball = draw_ball(artist, scene.ball_appearance);
  appearance.lamps[0] = draw_lamp(artist, scene.ball_appearance, -1.0, scene.photograph.lamp_a_power);
  appearance.lamps[1] = draw_lamp(artist, scene.ball_appearance, 1.0, scene.photograph.lamp_b_power);
  const BackgroundSettings& b = scene.background;
  appearance.background.wall = artist.scaled(0.01, 0.1, b.wall);
  appearance.background.wall_ramp = artist.between(-0.5, 0.5);
  appearance.background.plate_brightness = artist.scaled(0.4, 4.0, b.plate_brightness);
  appearance.background.plate_thickness_m = artist.between(8.0 * kMilli, 25.0 * kMilli, b.plate_thickness_m);
  appearance.background.plate_half_length_m = artist.between(
      1.05 * scene.camera.half_width_m, 1.3 * scene.camera.half_width_m, b.plate_half_length_m);
  appearance.background.clutter = artist.seed();
  appearance.blur_px = artist.between(0.5, 1.1, scene.photograph.blur_px);
  appearance.vignetting = artist.between(0.05, 0.3, scene.photograph.vignetting);
  appearance.noise = artist.seed();
  return appearance;
}

constexpr double kMarginAside_m = 0.045;
constexpr double kMarginAbove_m = 0.035;
constexpr int kNewtonSteps = 6;

int side(int asked, double holds_view) {
  if (asked > 0) return asked;
  return static_cast<int>(std::clamp(std::round(holds_view), 16.0, 20000.0));
}

/// g of g·(1 + beta·g²) = 1: the share of the seen distance from the axis that is the true one.
double straighten(double beta) {
  // Beyond this the curve has turned back.
  if (beta < -4.0 / 27.0) return 1.5;
  double g = 1.0;
  for (int i = 0; i < kNewtonSteps; ++i) g -= (g + beta * g * g * g - 1.0) / (1.0 + 3.0 * beta * g * g);
  return g;
}

}  // namespace

Appearance draw_appearance(const Scene& scene, std::uint64_t seed, int shot) {
  Appearance appearance = draw(scene, seed, shot);
  if (!scene.photograph.steady) return appearance;
  // The noise is each photograph's own, and so is how the ball lies.
  const std::uint64_t noise = appearance.noise, texture = appearance.ball.texture;
  appearance = draw(scene, seed, 0);
  appearance.noise = noise;
  appearance.ball.texture = texture;
  return appearance;
}

SensorSize sensor_size(const Scene& scene) {
  const CameraSettings& c = scene.camera;
  return {
      side(scene.photograph.width_px, c.origin_x_px + c.px_per_m * (c.half_width_m + kMarginAside_m)),
      side(scene.photograph.height_px, c.origin_y_px + c.px_per_m * (c.height_m + kMarginAbove_m)),
  };
}

Optics::Optics(const Scene& scene)
    : sensor_(sensor_size(scene)),
      px_per_m_(scene.camera.px_per_m),
      origin_x_px_(scene.camera.origin_x_px),
      origin_y_px_(scene.camera.origin_y_px),
      half_height_m_(0.5 * scene.camera.height_m),
      distance_m_(scene.camera.distance_m),
      mirrored_(scene.camera.mirrored) {
  const double turn =
      scene.camera.roll_rad + (mirrored_ ? -scene.surface_angle_rad : scene.surface_angle_rad);
  turn_cos_ = std::cos(turn);
  turn_sin_ = std::sin(turn);
  const double w = scene.camera.half_width_m;
  bend_pm2_ = scene.camera.distortion / (w * w + half_height_m_ * half_height_m_);
  if (!scene.camera.turned()) return;
  const Vec2 foot = image_of({0.0, 0.0, 0.0});
  foot_px_ = {foot.x, sensor_.height - 1.0 - foot.y};
  slant_ = Slant(scene.camera.swing_rad, scene.camera.tilt_rad, px_per_m_ * distance_m_);
}

Vec2 Optics::plane_at(double column, double row) const {
  if (!slant_.is_none()) {
    const Eigen::Vector2d square =
        foot_px_ + slant_.undo(Eigen::Vector2d(column, sensor_.height - 1.0 - row) - foot_px_);
    column = square.x();
    row = sensor_.height - 1.0 - square.y();
  }
  const double u = (column - origin_x_px_) / px_per_m_;
  const double v = (sensor_.height - 1.0 - row - origin_y_px_) / px_per_m_;
  const Vec2 seen{turn_cos_ * u + turn_sin_ * v, turn_cos_ * v - turn_sin_ * u - half_height_m_};
  if (bend_pm2_ == 0.0) return seen;
  const double g = straighten(bend_pm2_ * (seen.x * seen.x + seen.y * seen.y));
  return {g * seen.x, g * seen.y};
}

Vec2 Optics::image_of(const Vec3& p) const {
  const double nearer = perspective() ? distance_m_ / (distance_m_ - p.z) : 1.0;
  double x = nearer * p.x;
  double y = nearer * p.y;
  const double stretch = 1.0 + bend_pm2_ * (x * x + y * y);
  x *= stretch;
  y = stretch * y + half_height_m_;
  Eigen::Vector2d seen(origin_x_px_ + px_per_m_ * (turn_cos_ * x - turn_sin_ * y),
                       origin_y_px_ + px_per_m_ * (turn_sin_ * x + turn_cos_ * y));
  if (!slant_.is_none()) seen = foot_px_ + slant_.apply(Eigen::Vector2d(seen - foot_px_));
  return {seen.x(), sensor_.height - 1.0 - seen.y()};
}

Vec3 Optics::from_surface(double x_m, double y_m, double off_plane_m) const {
  return {mirrored_ ? -x_m : x_m, y_m - half_height_m_, off_plane_m};
}

}  // namespace strobe::sim
