#include "tests/studies/digitize/independent_render.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>

namespace strobe::studies::digitize {

namespace {

// The ball: a rough sphere in front of a pinhole. Metres, x right and y up from the middle of the view in the plane of
// flight, z towards the lens.

struct FeltLook {
  double roughness = 0.4;  ///< Oren and Nayar's sigma [rad]
  double grain = 0.06;     ///< of the albedo, relative
  double seam = 0.15;      ///< darker
  double line_width_m = 0.003, line_contrast = 0.8, line_tilt_rad = 0.0, line_offset = 0.0;
  double fringe_px = 0.5;  ///< width over which fibres fade at the limb
  double hairs_px = 0.15;  ///< by which the limb wavers
  bool line = true;
  std::uint64_t texture = 1;
};

struct FeltBall {
  cv::Vec3d centre;
  double radius_m = 0.0325;
  double equator_rad = 0.0;
  double floor_m = -1e9;  ///< y of the surface that cuts it off
  std::array<double, 2> light{};
  /// From its own axes to the view's; absent: turned by equator_rad about z.
  std::optional<cv::Matx33d> attitude{};

  cv::Vec3d own(const cv::Vec3d& v) const {
    if (attitude) return attitude->t() * v;
    const double c = std::cos(equator_rad), s = std::sin(equator_rad);
    return {c * v[0] + s * v[1], c * v[1] - s * v[0], v[2]};
  }
  /// Of the plane that the line is in.
  cv::Vec3d normal(double tilt_rad) const {
    const double c = std::cos(tilt_rad), s = std::sin(tilt_rad);
    if (attitude) return *attitude * cv::Vec3d(0.0, c, s);
    return {-std::sin(equator_rad) * c, std::cos(equator_rad) * c, s};
  }
};

double hashed(std::uint64_t seed, int x, int y, int z) {
  std::uint64_t h = seed;
  for (const int part : {x, y, z}) {
    h ^= static_cast<std::uint64_t>(static_cast<std::int64_t>(part)) + 0x9e3779b97f4a7c15ULL + (h << 6) +
         (h >> 2);
    h *= 0xff51afd7ed558ccdULL;
    h ^= h >> 33;
  }
  return static_cast<double>(h >> 11) * 0x1p-53;
}

double smooth(double t) { return t * t * (3.0 - 2.0 * t); }

/// 0 to 1, smooth over a length of 1.
double value_noise(std::uint64_t seed, const cv::Vec3d& at) {
  const int x = static_cast<int>(std::floor(at[0])), y = static_cast<int>(std::floor(at[1])),
            z = static_cast<int>(std::floor(at[2]));
  const double u = smooth(at[0] - x), v = smooth(at[1] - y), w = smooth(at[2] - z);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
    sum += (i ? u : 1.0 - u) * (j ? v : 1.0 - v) * (k ? w : 1.0 - w) * hashed(seed, x + i, y + j, z + k);
  }
  return sum;
}

/// Oren and Nayar (1994), the qualitative model.
double rough_reflection(double roughness, const cv::Vec3d& n, const cv::Vec3d& in, const cv::Vec3d& out) {
  const double cos_in = n.dot(in), cos_out = std::max(n.dot(out), 1e-3);
  if (cos_in <= 0.0) return 0.0;
  const double s2 = roughness * roughness;
  const double a = 1.0 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
  const cv::Vec3d in_flat = in - n * cos_in, out_flat = out - n * cos_out;
  const double across = in_flat.dot(out_flat) / std::max(cv::norm(in_flat) * cv::norm(out_flat), 1e-9);
  const double sin_in = std::sqrt(std::max(0.0, 1.0 - cos_in * cos_in));
  const double sin_out = std::sqrt(std::max(0.0, 1.0 - cos_out * cos_out));
  // The larger angle's sine, the smaller one's tangent.
  const double steep = cos_in < cos_out ? sin_in * sin_out / cos_out : sin_out * sin_in / cos_in;
  return cos_in * (a + b * std::max(0.0, across) * steep);
}

double albedo(const FeltLook& look, double radius_m, const cv::Vec3d& own) {
  constexpr double kFibre_m = 0.0009, kClump_m = 0.004;
  const cv::Vec3d at = own * radius_m;
  double value = 1.0 + look.grain * (1.8 * (value_noise(look.texture, at * (1.0 / kFibre_m)) - 0.5) +
                                     1.8 * (value_noise(look.texture + 1, at * (1.0 / kClump_m)) - 0.5));
  // Two small circles stand for the seam.
  const double seam = std::min(std::abs(own[0] - 0.55), std::abs(own[2] + 0.35)) * radius_m / 0.0015;
  value *= 1.0 - look.seam * std::exp(-seam * seam);
  if (!look.line) return value;
  const double off_m =
      radius_m * std::abs(std::cos(look.line_tilt_rad) * own[1] + std::sin(look.line_tilt_rad) * own[2] -
                          look.line_offset);
  constexpr double kInkEdge_m = 0.00025;
  return value *
         (1.0 - look.line_contrast / (1.0 + std::exp((off_m - 0.5 * look.line_width_m) / kInkEdge_m)));
}

/// Light that the felt sends to the lens from where a ray meets the ball, over that of a white sheet that faces a lamp.
/// `normal`: of length 1, from the ball's centre.
double felt_light(const FeltLook& look, const FeltBall& ball, const std::array<cv::Vec3d, 2>& lamps,
                  const cv::Vec3d& normal, const cv::Vec3d& to_lens) {
  const cv::Vec3d own = ball.own(normal);
  const cv::Vec3d at = ball.centre + normal * ball.radius_m;
  double light = 0.0;
  for (std::size_t lamp = 0; lamp < lamps.size(); ++lamp) {
    if (!(ball.light[lamp] > 0.0)) continue;
    const cv::Vec3d way = lamps[lamp] - at;
    const double away2 = way.dot(way), usual2 = lamps[lamp].dot(lamps[lamp]);
    light += ball.light[lamp] * usual2 / away2 *
             rough_reflection(look.roughness, normal, way * (1.0 / std::sqrt(away2)), to_lens);
  }
  return light * albedo(look, ball.radius_m, own);
}

/// Of a sum of waves around the limb, px.
double limb_waver(const FeltLook& look, const FeltBall& ball, double angle_rad) {
  double sum = 0.0;
  for (const int waves : {7, 19, 43}) {
    const double phase = 6.283 * hashed(look.texture, waves, 0, 0);
    sum += std::sin(waves * (angle_rad - ball.equator_rad) + phase);
  }
  return look.hairs_px * sum / std::sqrt(1.5);
}

// The camera: a lens with glare, a colour sensor with a Bayer mosaic and uneven pixels, and the curve by which its
// file's numbers follow the light.

struct IndependentCamera {
  double blur_px = 0.8, glare = 0.03, vignetting = 0.2;
  double exposure = 1.0;  ///< times light: 1 saturates
  double noise = 1.0;     ///< over the usual
  double black = 0.0;     ///< light that a dark sensor shows
  double gamma = 1.0;
};

/// A sharp core, and glare over tens of pixels.
void spread(const IndependentCamera& camera, cv::Mat& light) {
  cv::Mat wide, small;
  cv::resize(light, small, {}, 0.125, 0.125, cv::INTER_AREA);
  cv::GaussianBlur(small, small, {0, 0}, 5.0);
  cv::resize(small, wide, light.size(), 0, 0, cv::INTER_LINEAR);
  if (camera.blur_px > 0.0) cv::GaussianBlur(light, light, {0, 0}, camera.blur_px);
  light = light * (1.0 - camera.glare) + wide * camera.glare;
}

/// Blue, green, red: yellow felt before grey things, and the sensor's own sensitivity.
constexpr std::array<double, 3> kFelt{0.45, 1.0, 0.85}, kGrey{0.85, 1.0, 0.8};

cv::Mat mosaic_of(const IndependentCamera& camera, const cv::Mat& felt, const cv::Mat& behind,
                  std::mt19937_64& random) {
  constexpr double kFullWell_e = 12000.0, kRead_e = 6.0, kUneven = 0.008;
  std::normal_distribution<double> normal;
  cv::Mat mosaic(felt.size(), CV_16UC1);
  for (int row = 0; row < felt.rows; ++row) {
    for (int column = 0; column < felt.cols; ++column) {
      const std::size_t colour = (row & 1) == (column & 1) ? 1 : (row & 1) == 0 ? 2 : 0;  // GRBG
      const double x = 2.0 * column / felt.cols - 1.0, y = 2.0 * row / felt.rows - 1.0;
      const double seen = camera.exposure * (1.0 - 0.5 * camera.vignetting * (x * x + y * y)) *
                          (kFelt[colour] * static_cast<double>(felt.at<float>(row, column)) +
                           kGrey[colour] * static_cast<double>(behind.at<float>(row, column)));
      const double electrons = kFullWell_e * std::max(0.0, seen * (1.0 + kUneven * normal(random)));
      const double read =
          electrons + camera.noise * std::sqrt(electrons + kRead_e * kRead_e) * normal(random);
      mosaic.at<std::uint16_t>(row, column) =
          cv::saturate_cast<std::uint16_t>(65535.0 * (read / kFullWell_e + camera.black));
    }
  }
  return mosaic;
}

/// CV_16UC3, blue first, of the light of yellow felt and of grey things behind it (CV_32FC1; changed).
cv::Mat develop(const IndependentCamera& camera, cv::Mat felt, cv::Mat behind, std::mt19937_64& random) {
  spread(camera, felt);
  spread(camera, behind);
  cv::Mat pixels;
  cv::cvtColor(mosaic_of(camera, felt, behind, random), pixels, cv::COLOR_BayerGB2BGR);
  if (camera.gamma != 1.0) {
    cv::Mat light;
    pixels.convertTo(light, CV_32F, 1.0 / 65535.0);
    cv::pow(light, camera.gamma, light);
    light.convertTo(pixels, CV_16U, 65535.0);
  }
  return pixels;
}

constexpr double kDegree = std::numbers::pi / 180.0;
/// A flash's light: when, and how much of it. Its mean is what the ball's place is true of.
constexpr std::array<std::array<double, 2>, 3> kFlash{{{0.0, 0.6}, {3e-6, 0.3}, {8e-6, 0.1}}};
constexpr double kFlashMean_s = 1.7e-6;

/// The pinhole, and the pixels of the plane of flight.
struct View {
  int width = 0, height = 0;
  double px_per_m = 4000.0, distance_m = 2.4, roll = 0.0;
  double left_m = 0.0, top_m = 0.0;  ///< of the first pixel's centre, from the view's middle
  double surface_m = 0.0;            ///< y of the surface

  cv::Vec3d lens() const { return {0.0, 0.0, distance_m}; }
  /// Where a pixel's ray meets the plane of flight.
  cv::Vec3d plane(double column, double row) const {
    const double x = left_m + column / px_per_m, y = top_m - row / px_per_m;
    return {std::cos(roll) * x - std::sin(roll) * y, std::sin(roll) * x + std::cos(roll) * y, 0.0};
  }
  cv::Point2d pixel(const cv::Vec3d& point) const {
    const double share = distance_m / (distance_m - point[2]);
    const double x = std::cos(roll) * point[0] * share + std::sin(roll) * point[1] * share;
    const double y = -std::sin(roll) * point[0] * share + std::cos(roll) * point[1] * share;
    return {(x - left_m) * px_per_m, (top_m - y) * px_per_m};
  }
};

View view_of(const sim::Scene& scene, std::mt19937_64& random) {
  const auto& camera = scene.camera;
  View view;
  view.px_per_m = camera.px_per_m;
  view.distance_m = std::uniform_real_distribution(1.8, 3.5)(random);
  view.roll = std::normal_distribution(0.0, 0.4 * kDegree)(random);
  constexpr double kMargin_m = 0.05;
  const double half_m = camera.half_width_m + kMargin_m, high_m = camera.height_m + 2.0 * kMargin_m;
  view.width = static_cast<int>(2.0 * half_m * view.px_per_m) & ~1;
  view.height = static_cast<int>(high_m * view.px_per_m) & ~1;
  view.left_m = -half_m;
  view.top_m = 0.5 * high_m;
  view.surface_m = -0.5 * high_m + kMargin_m;
  return view;
}

struct Look {
  FeltLook felt;
  std::array<cv::Vec3d, 2> lamps;
  std::array<double, 2> power{};
  double wall = 0.03, plate = 1.0, blur_px = 0.8, glare = 0.03, vignetting = 0.2;
  std::uint64_t background = 1;
};

Look look_of(const sim::Scene& scene, std::mt19937_64& random) {
  const auto between = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
  const auto& ball = scene.ball_appearance;
  Look look;
  look.felt = {
      between(0.2, 0.6),  between(0.02, 0.1),
      between(0.0, 0.3),  between(0.0018, 0.004),
      between(0.5, 0.95), std::clamp(std::normal_distribution(0.0, 1.5)(random), -5.0, 5.0) * kDegree,
      ball.line_offset,   between(0.2, 1.0),
      between(0.0, 0.2),  ball.line,
      random()};
  look.felt.line_contrast = ball.line_contrast.value_or(look.felt.line_contrast);
  look.felt.line_tilt_rad = ball.line_tilt_rad.value_or(look.felt.line_tilt_rad);
  look.felt.line_width_m = ball.line_width_m.value_or(look.felt.line_width_m);
  look.lamps = {cv::Vec3d(-between(0.5, 1.4), between(-0.1, 0.9), between(0.6, 1.8)),
                cv::Vec3d(between(0.5, 1.4), between(-0.1, 0.9), between(0.6, 1.8))};
  look.power = {scene.photograph.lamp_a_power * between(0.8, 1.2),
                scene.photograph.lamp_b_power * between(0.8, 1.2)};
  look.wall = between(0.01, 0.08);
  look.plate = between(0.4, 2.5);
  look.blur_px = scene.photograph.blur_px.value_or(between(0.5, 1.1));
  look.glare = between(0.0, 0.06);
  look.vignetting = between(0.05, 0.3);
  look.background = random();
  return look;
}

struct Flash {
  FeltBall ball;  ///< at the mean of its light
  std::vector<FeltBall> moments;
  double time_s = 0.0;
  reduction::Leg leg{};
  bool other = false;  ///< of a second ball
};

FeltBall ball_of(const View& view, const sim::Scene& scene, const sim::BallPath& path, double since_s) {
  const sim::BallState state = path.at(since_s);
  const double radius_m = 0.5 * scene.ball.diameter_m;
  const double high_m = state.top_drop_m > 0.0 ? radius_m - state.top_drop_m : state.y_m;
  FeltBall ball;
  ball.centre = {state.x_m + path.spot_m(), view.surface_m + high_m, path.off_plane_m() + state.z_m};
  ball.radius_m = radius_m;
  ball.equator_rad = state.equator_rad;
  if (!path.planar()) {
    const Eigen::Matrix3d turned = state.attitude();
    ball.attitude = cv::Matx33d(turned(0, 0), turned(0, 1), turned(0, 2), turned(1, 0), turned(1, 1),
                                turned(1, 2), turned(2, 0), turned(2, 1), turned(2, 2));
    // As far as the limb's wavering turns with it.
    ball.equator_rad = std::atan2(turned(1, 0), turned(0, 0));
  }
  if (high_m < radius_m) ball.floor_m = view.surface_m;
  return ball;
}

std::vector<Flash> flashes_of_one(const View& view, const Look& look, const sim::Scene& scene,
                                  const sim::Exposure& exposure, std::mt19937_64& random) {
  const double second = scene.photograph.second_flash, second_s = scene.photograph.second_flash_s;
  std::normal_distribution<double> power(1.0, 0.03);
  std::vector<Flash> flashes;
  for (const sim::FilmImage& film : sim::film_images(scene, exposure)) {
    const sim::BallPath& path = exposure.ball->path;
    const double since_s = to_seconds(film.time - exposure.ball->touchdown);
    const std::array<double, 2> light{look.power[0] * power(random), look.power[1] * power(random)};
    if (light[0] + light[1] <= 0.0) continue;
    Flash flash;
    flash.ball = ball_of(view, scene, path, since_s + kFlashMean_s + second * second_s);
    flash.time_s = to_seconds(film.time - exposure.pulses.front().edge);
    const auto add = [&](double later_s, double share) {
      flash.moments.push_back(ball_of(view, scene, path, since_s + later_s));
      flash.moments.back().light = {share * light[0], share * light[1]};
    };
    for (const auto& [later_s, share] : kFlash) {
      add(later_s, (1.0 - second) * share);
      if (second > 0.0) add(second_s + later_s, second * share);
    }
    const bool contact = film.state.top_drop_m > 0.0;
    flash.leg = contact                          ? reduction::Leg::contact
                : since_s > 0.5 * path.dwell_s() ? reduction::Leg::rebound
                                                 : reduction::Leg::incoming;
    flashes.push_back(std::move(flash));
  }
  return flashes;
}

/// Lit by every flash.
Flash at_rest(const View& view, const Look& look, const sim::Scene& scene, const sim::Exposure& exposure,
              double x_m) {
  Flash flash;
  flash.other = true;
  flash.ball.radius_m = 0.5 * scene.ball.diameter_m;
  flash.ball.centre = {x_m, view.surface_m + flash.ball.radius_m, 0.0};
  flash.ball.equator_rad = 0.7;
  const auto pulses = static_cast<double>(exposure.pulses.size());
  flash.moments.push_back(flash.ball);
  flash.moments.back().light = {pulses * look.power[0], pulses * look.power[1]};
  return flash;
}

/// Second balls' come last.
std::vector<Flash> flashes_of(const View& view, const Look& look, const sim::Scene& scene,
                              const sim::Exposure& exposure, std::optional<double> at_rest_m,
                              std::mt19937_64& random) {
  std::vector<Flash> flashes = flashes_of_one(view, look, scene, exposure, random);
  for (const sim::ThrownBall& ball : exposure.more_balls) {
    sim::Exposure other = exposure;
    other.ball = ball;
    for (Flash& flash : flashes_of_one(view, look, scene, other, random)) {
      flash.other = true;
      flashes.push_back(std::move(flash));
    }
  }
  if (at_rest_m) flashes.push_back(at_rest(view, look, scene, exposure, *at_rest_m));
  return flashes;
}

/// The circle where rays touch the ball: two directions across the line of sight and how far towards the lens it is.
struct Limb {
  cv::Vec3d towards, across, up;
  double height = 0.0, radius = 0.0;
};

Limb limb_of(const View& view, const FeltBall& ball) {
  const cv::Vec3d way = view.lens() - ball.centre;
  const double away = cv::norm(way);
  Limb limb;
  limb.towards = way * (1.0 / away);
  limb.across = cv::normalize(cv::Vec3d(0.0, 1.0, 0.0).cross(limb.towards));
  limb.up = limb.towards.cross(limb.across);
  limb.height = ball.radius_m * ball.radius_m / away;
  limb.radius = ball.radius_m * std::sqrt(1.0 - limb.height / away);
  return limb;
}

/// Plane px, y up.
reduction::PointPx upright(const View& view, cv::Point2d pixel) {
  return {pixel.x, view.height - 1.0 - pixel.y};
}

TrueImage truth_of(const View& view, const Look& look, const Flash& flash) {
  const FeltBall& ball = flash.ball;
  const Limb limb = limb_of(view, ball);
  std::vector<cv::Point2d> outline;
  for (int i = 0; i < 360; ++i) {
    const double a = i * kDegree;
    outline.push_back(view.pixel(ball.centre + limb.towards * limb.height +
                                 (limb.across * std::cos(a) + limb.up * std::sin(a)) * limb.radius));
  }
  double twice_area = 0.0;
  cv::Point2d sum;
  TrueImage image;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const cv::Point2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice_area += a.cross(b);
    sum += (a + b) * a.cross(b);
    image.whole = image.whole && a.x > 0.0 && a.y > 0.0 && a.x < view.width - 1.0 && a.y < view.height - 1.0;
  }
  image.leg = flash.leg;
  image.centre_px = upright(view, sum * (1.0 / (3.0 * twice_area)));
  // The polygon's area is less than the ellipse's by its chords.
  const double chords = 0.5 * 360.0 * std::sin(kDegree) / std::numbers::pi;
  image.diameter_px = std::sqrt(4.0 * 0.5 * std::abs(twice_area) / chords / std::numbers::pi);
  if (look.felt.line) {
    const cv::Vec3d across = ball.normal(look.felt.line_tilt_rad);
    // On the limb and on the line: towards . p = height, across . p = off, |p| = R.
    const double tilted = across.dot(limb.towards), off = look.felt.line_offset * ball.radius_m;
    const cv::Vec3d along = cv::normalize(across.cross(limb.towards));
    const cv::Vec3d level = cv::normalize(limb.towards - across * across.dot(limb.towards));
    const double a = (limb.height - off * tilted) / level.dot(limb.towards),
                 b = std::sqrt(std::max(0.0, ball.radius_m * ball.radius_m - off * off - a * a));
    const cv::Vec3d middle = ball.centre + across * off + level * a;
    const cv::Point2d way = view.pixel(middle + along * b) - view.pixel(middle - along * b);
    image.equator_rad = std::atan2(-way.y, way.x);
    image.equator_tilt_rad = -std::asin(tilted);
  }
  return image;
}

/// Adds a ball's light and takes away what it hides.
void paint(const View& view, const Look& look, const FeltBall& ball, const cv::Mat& scenery,
           double hidden_share, cv::Mat& felt, cv::Mat& hidden) {
  const cv::Point2d middle = view.pixel(ball.centre);
  const double nearer = ball.attitude ? view.distance_m / (view.distance_m - ball.centre[2]) : 1.0;
  const double radius_px = ball.radius_m * view.px_per_m * nearer, reach = radius_px + 5.0;
  const cv::Rect box =
      cv::Rect(cv::Point(static_cast<int>(middle.x - reach), static_cast<int>(middle.y - reach)),
               cv::Point(static_cast<int>(middle.x + reach), static_cast<int>(middle.y + reach))) &
      cv::Rect(0, 0, view.width, view.height);
  for (int row = box.y; row < box.y + box.height; ++row) {
    for (int column = box.x; column < box.x + box.width; ++column) {
      const double outside_px = std::hypot(column - middle.x, row - middle.y) - radius_px;
      const int steps = outside_px > 4.0 ? 0 : outside_px > -4.0 || ball.floor_m > -1e8 ? 3 : 1;
      double light = 0.0, cover = 0.0;
      for (int sub = 0; sub < steps * steps; ++sub) {
        const cv::Vec3d at =
            view.plane(column + (sub % steps + 0.5) / steps - 0.5, row + (sub / steps + 0.5) / steps - 0.5);
        const cv::Vec3d to_lens = cv::normalize(view.lens() - at);
        const cv::Vec3d aside = at - ball.centre - to_lens * to_lens.dot(at - ball.centre);
        const double share = cv::norm(aside) / ball.radius_m;
        const double waver = limb_waver(look.felt, ball, std::atan2(aside[1], aside[0]));
        const double inside_px = (1.0 - share) * radius_px + waver;
        double c = std::clamp(0.5 + inside_px / std::max(look.felt.fringe_px, 1.0 / steps), 0.0, 1.0);
        if (c <= 0.0) continue;
        const double depth = std::sqrt(std::max(0.0, 1.0 - share * share));
        const cv::Vec3d normal = cv::normalize(aside * (1.0 / ball.radius_m) + to_lens * depth);
        if (ball.centre[1] + ball.radius_m * normal[1] < ball.floor_m) continue;
        cover += c;
        light += c * felt_light(look.felt, ball, look.lamps, normal, to_lens);
      }
      if (cover == 0.0) continue;
      const double samples = steps * steps;
      felt.at<float>(row, column) += static_cast<float>(light / samples);
      hidden.at<float>(row, column) += static_cast<float>(
          hidden_share * cover / samples * static_cast<double>(scenery.at<float>(row, column)));
    }
  }
}

/// Uneven over decimetres.
cv::Mat wall_of(const View& view, const Look& look) {
  constexpr int kCoarse = 8;
  cv::Mat coarse((view.height + kCoarse - 1) / kCoarse, (view.width + kCoarse - 1) / kCoarse, CV_32FC1), wall;
  for (int row = 0; row < coarse.rows; ++row) {
    for (int column = 0; column < coarse.cols; ++column)
      coarse.at<float>(row, column) = static_cast<float>(
          look.wall *
          (0.6 + 0.8 * value_noise(look.background, view.plane(kCoarse * column, kCoarse * row) * 9.0)));
  }
  cv::resize(coarse, wall, {view.width, view.height}, 0, 0, cv::INTER_LINEAR);
  return wall;
}

/// Light of wall, plate and foreign things, of the whole exposure.
cv::Mat scenery_of(const View& view, const Look& look, int blobs) {
  cv::Mat scenery = wall_of(view, look);
  constexpr double kPlate_m = 0.016;
  for (int row = 0; row < view.height; ++row) {
    for (int column = 0; column < view.width; ++column) {
      const cv::Vec3d at = view.plane(column, row);
      const double deep = view.surface_m - at[1];
      if (deep > 0.0 && deep < kPlate_m)
        scenery.at<float>(row, column) =
            static_cast<float>(look.plate * (0.9 + 0.2 * value_noise(look.background + 1, at * 300.0)));
    }
  }
  std::mt19937_64 random(look.background);
  for (int i = 0; i < blobs; ++i) {
    const auto in = [&](double least, double most) {
      return std::uniform_real_distribution(least, most)(random);
    };
    const cv::Point at(static_cast<int>(in(0.05, 0.95) * view.width),
                       static_cast<int>(in(0.05, 0.6) * view.height));
    const double size = 0.03 * view.px_per_m;
    cv::ellipse(scenery, at,
                cv::Size(static_cast<int>(in(0.3, 1.0) * size), static_cast<int>(in(0.3, 1.0) * size)),
                in(0.0, 180.0), 0.0, 360.0, cv::Scalar(in(0.5, 1.5)), cv::FILLED, cv::LINE_AA);
  }
  // Edges of real things are not as sharp as drawn ones.
  cv::GaussianBlur(scenery, scenery, {0, 0}, 0.5);
  return scenery;
}

/// All that is drawn before a photograph is taken.
struct Draft {
  std::mt19937_64 random;
  View view;
  Look look;
  std::vector<Flash> flashes;
};

Draft draft_of(const sim::Scene& scene, const sim::Exposure& exposure, std::uint64_t seed,
               const IndependentLook& extra) {
  Draft draft;
  draft.random.seed(seed * 7919 + static_cast<std::uint64_t>(exposure.shot));
  draft.view = view_of(scene, draft.random);
  draft.look = look_of(scene, draft.random);
  draft.flashes =
      flashes_of(draft.view, draft.look, scene, exposure, extra.ball_at_rest_m, draft.random);
  return draft;
}

IndependentCamera camera_of(const sim::Scene& scene, const Look& look, const IndependentLook& extra) {
  // The lightest felt of one image is at two fifths of what saturates.
  constexpr double kUsual = 0.4 / 1.3;
  return {.blur_px = look.blur_px,
          .glare = look.glare,
          .vignetting = look.vignetting,
          .exposure = kUsual * scene.photograph.exposure,
          .noise = extra.noise,
          .black = scene.photograph.black_level,
          .gamma = scene.photograph.gamma};
}

}  // namespace

IndependentTruth independent_truth(const sim::Scene& scene, const sim::Exposure& exposure,
                                   std::uint64_t seed, const IndependentLook& extra) {
  const Draft draft = draft_of(scene, exposure, seed, extra);
  IndependentTruth truth;
  for (const Flash& flash : draft.flashes) {
    if (flash.other) {
      truth.others.push_back(truth_of(draft.view, draft.look, flash));
      continue;
    }
    truth.images.push_back(truth_of(draft.view, draft.look, flash));
    truth.times_s.push_back(flash.time_s);
  }
  for (const double x_m : {-0.2, 0.2})
    truth.surface_px.push_back(upright(draft.view, draft.view.pixel({x_m, draft.view.surface_m, 0.0})));
  const reduction::PointPx foot = upright(draft.view, draft.view.pixel({0.0, 0.0, 0.0}));
  truth.viewpoint_px = {foot.x, foot.y, draft.view.distance_m * draft.view.px_per_m};
  return truth;
}

cv::Mat render_independently(const sim::Scene& scene, const sim::Exposure& exposure, std::uint64_t seed,
                             const IndependentLook& extra) {
  Draft draft = draft_of(scene, exposure, seed, extra);
  const Look& look = draft.look;
  const cv::Mat scenery = scenery_of(draft.view, look, scene.background.blobs);
  cv::Mat felt(scenery.size(), CV_32FC1, cv::Scalar(0.0)), hidden = felt.clone();
  const auto pulses = static_cast<double>(std::max<std::size_t>(exposure.pulses.size(), 1));
  const double all = look.power[0] + look.power[1];
  for (const Flash& flash : draft.flashes) {
    for (const FeltBall& moment : flash.moments)
      paint(draft.view, look, moment, scenery, (moment.light[0] + moment.light[1]) / all / pulses, felt,
            hidden);
  }
  return develop(camera_of(scene, look, extra), felt, scenery - hidden, draft.random);
}

}  // namespace strobe::studies::digitize
