#include "tests/host/digitize/painter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace strobe::testing {

namespace {

constexpr int kSubpixels = 10;

double lattice(std::uint64_t seed, int i, int j, int k) {
  std::uint64_t h = seed * 0x9E3779B97F4A7C15ULL;
  for (const int v : {i, j, k}) {
    h ^= static_cast<std::uint32_t>(v) + 0x632BE59BD9B4E019ULL + (h << 6) + (h >> 2);
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ULL;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBULL;
    h ^= h >> 31;
  }
  return std::ldexp(static_cast<double>(h >> 11), -53) - 0.5;
}

/// Smooth noise over space, of sd near one and the grain's size one.
double noise(std::uint64_t seed, const cv::Vec3d& at) {
  std::array<int, 3> cell{};
  std::array<double, 3> part{};
  for (int a = 0; a < 3; ++a) {
    const double whole = std::floor(at[a]);
    cell[a] = static_cast<int>(whole);
    const double t = at[a] - whole;
    part[a] = t * t * (3.0 - 2.0 * t);
  }
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    for (int a = 0; a < 3; ++a) weight *= ((corner >> a) & 1) != 0 ? part[a] : 1.0 - part[a];
    sum += weight *
           lattice(seed, cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + (corner >> 2));
  }
  return 6.0 * sum;
}

/// A rotation drawn from the seed, turned further about the line of sight by the line's angle.
cv::Matx33d turned(std::uint64_t seed, double angle) {
  cv::Vec4d q(lattice(seed, 1, 7, 3), lattice(seed, 2, 7, 3), lattice(seed, 3, 7, 3), lattice(seed, 4, 7, 3));
  q *= 1.0 / std::max(cv::norm(q), 1e-9);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const cv::Matx33d fixed(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
                          2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),  //
                          2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
  const double c = std::cos(angle), s = std::sin(angle);
  return fixed * cv::Matx33d(c, s, 0, -s, c, 0, 0, 0, 1);
}

double soft_band(double distance, double width, double edge) {
  return 0.5 * (std::erf((distance + width / 2) / (edge + 1e-9)) -
                std::erf((distance - width / 2) / (edge + 1e-9)));
}

class Sphere {
 public:
  explicit Sphere(const PaintedBall& ball)
      : ball_(ball),
        radius_(ball.diameter_px / 2),
        turned_(turned(ball.seed, ball.line ? ball.line->angle_rad : 0.0)) {
    for (auto& lamp : ball_.lamps) lamp.towards *= 1.0 / cv::norm(lamp.towards);
  }

  double outline(double x, double y) const {
    if (ball_.fuzz_px == 0.0) return radius_;
    const double r = std::max(std::hypot(x, y), 1e-9);
    const cv::Vec3d at = turned_ * cv::Vec3d(x / r, y / r, 0.0) * (radius_ / ball_.grain_px);
    return radius_ + ball_.fuzz_px * noise(ball_.seed + 5, at);
  }

  /// x to the right, y up from the centre; inside the outline.
  double light(double x, double y) const {
    const double r2 = (x * x + y * y) / (radius_ * radius_);
    const cv::Vec3d n(x / radius_, y / radius_, std::sqrt(std::max(0.0, 1.0 - r2)));
    double sum = ball_.ambient;
    for (const auto& lamp : ball_.lamps) {
      const double cosine = lamp.towards.dot(n);
      if (cosine > 0.0) sum += lamp.strength * std::pow(cosine, ball_.limb);
    }
    return std::max(0.0, ball_.light * sum * texture(n));
  }

 private:
  double texture(const cv::Vec3d& n) const {
    const cv::Vec3d on_ball = turned_ * n;
    double factor = 1.0;
    if (ball_.grain > 0.0) {
      const double cells = radius_ / ball_.grain_px;
      factor += ball_.grain * (0.8 * noise(ball_.seed, on_ball * cells) +
                               0.6 * noise(ball_.seed + 1, on_ball * (cells / 6)));
    }
    if (ball_.seam_contrast > 0.0) {
      const double distance = (on_ball[2] - 1.8 * on_ball[0] * on_ball[1]) * radius_ / 1.4;
      factor *= 1.0 - ball_.seam_contrast * soft_band(distance, ball_.seam_width_px, 1.0);
    }
    if (ball_.line)
      factor *=
          1.0 - ball_.line->contrast * soft_band(from_line(n), ball_.line->width_px, ball_.line->edge_px);
    return factor;
  }

  double from_line(const cv::Vec3d& n) const {
    const double across = -n[0] * std::sin(ball_.line->angle_rad) + n[1] * std::cos(ball_.line->angle_rad);
    const double f = across * std::cos(ball_.line->tilt_rad) - n[2] * std::sin(ball_.line->tilt_rad);
    return radius_ * (std::asin(std::clamp(f, -1.0, 1.0)) - std::asin(ball_.line->offset));
  }

  PaintedBall ball_;
  double radius_;
  cv::Matx33d turned_;
};

class Background {
 public:
  explicit Background(const Painting& painting) : painting_(painting) {}
  double light(double x, double row) const {
    if (painting_.plate_row && row > *painting_.plate_row) return painting_.plate;
    const double dx = x - 0.5 * painting_.width, dy = row - 0.5 * painting_.height;
    return painting_.background *
           std::max(0.0, 1.0 + dx * painting_.background_slope_px.x + dy * painting_.background_slope_px.y);
  }

 private:
  const Painting& painting_;
};

void add_ball(cv::Mat& light, const Painting& painting, const PaintedBall& ball) {
  const Sphere sphere(ball);
  const Background background(painting);
  const double reach = ball.diameter_px / 2 + 4 * ball.fuzz_px + 1;
  const int top = std::max(0, static_cast<int>(ball.centre.y - reach));
  const int bottom = std::min(painting.height - 1, static_cast<int>(ball.centre.y + reach) + 1);
  const int left = std::max(0, static_cast<int>(ball.centre.x - reach));
  const int right = std::min(painting.width - 1, static_cast<int>(ball.centre.x + reach) + 1);
  for (int row = top; row <= bottom; ++row) {
    for (int x = left; x <= right; ++x) {
      const double dx = x - ball.centre.x, dy = ball.centre.y - row;
      const double r = std::hypot(dx, dy), edge = sphere.outline(dx, dy);
      const bool at_floor = ball.floor_row && std::abs(row - *ball.floor_row) < 1.0;
      const bool narrow = ball.line && std::abs(ball.line->tilt_rad) > 0.2;
      const int n = std::abs(r - edge) < 2.0 || at_floor ? kSubpixels : narrow ? 4 : 2;
      double sum = 0.0;
      for (int k = 0; k < n * n; ++k) {
        const double sx = dx + (k % n + 0.5) / n - 0.5, sy = dy - (k / n + 0.5) / n + 0.5;
        if (std::hypot(sx, sy) > sphere.outline(sx, sy) ||
            (ball.floor_row && ball.centre.y - sy > *ball.floor_row))
          continue;
        sum += sphere.light(sx, sy) -
               background.light(ball.centre.x + sx, ball.centre.y - sy) / painting.flashes;
      }
      light.at<double>(row, x) += sum / (n * n);
    }
  }
}

void expose(cv::Mat& light, const Painting& painting) {
  std::mt19937_64 random(painting.seed);
  std::normal_distribution<double> normal;
  const double corner = std::hypot(painting.width, painting.height) / 2;
  const double top = painting.bits == 8 ? 255.0 : painting.bits == 12 ? 4095.0 : 65535.0;
  const double range = painting.bits == 8 ? 255.0 : 65535.0;
  for (int row = 0; row < painting.height; ++row) {
    for (int x = 0; x < painting.width; ++x) {
      double& value = light.at<double>(row, x);
      const double off = std::hypot(x - 0.5 * painting.width, row - 0.5 * painting.height) / corner;
      value *= 1.0 - painting.vignetting * off * off;
      const double shot =
          painting.electrons > 0.0 ? std::sqrt(std::max(0.0, value) / painting.electrons) : 0.0;
      value += std::hypot(shot, painting.read_noise) * normal(random);
      value = std::round(std::clamp(value, 0.0, 1.0) * top) / range;
    }
  }
}

}  // namespace

digitize::Photograph paint(const Painting& painting) {
  cv::Mat light(painting.height, painting.width, CV_64F);
  const Background background(painting);
  for (int row = 0; row < painting.height; ++row)
    for (int x = 0; x < painting.width; ++x) light.at<double>(row, x) = background.light(x, row);
  for (const PaintedBall& ball : painting.balls) add_ball(light, painting, ball);
  if (painting.blur_px > 0.0) {
    const int size = 2 * static_cast<int>(std::ceil(4 * painting.blur_px)) + 1;
    cv::GaussianBlur(light, light, cv::Size(size, size), painting.blur_px, painting.blur_px,
                     cv::BORDER_REPLICATE);
  }
  expose(light, painting);
  digitize::Photograph photograph;
  light.convertTo(photograph.intensity, CV_32F);
  photograph.bits = painting.bits == 8 ? 8 : 16;
  photograph.saturation = painting.bits == 12 ? 4095.0F / 65535.0F : 1.0F;
  photograph.name = "painted";
  return photograph;
}

PaintedBall random_ball(std::mt19937_64& random, cv::Point2d centre, double diameter_px) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double low, double high) { return low + (high - low) * unit(random); };
  PaintedBall ball;
  ball.centre = centre;
  ball.diameter_px = diameter_px;
  ball.light = between(0.15, 0.4);
  ball.lamps = {{{-between(0.5, 1.5), between(0.0, 0.8), between(0.5, 1.5)}, between(0.6, 1.0)},
                {{between(0.5, 1.5), between(0.0, 0.8), between(0.5, 1.5)}, between(0.6, 1.0)}};
  ball.ambient = between(0.02, 0.2);
  ball.limb = between(0.5, 1.1);
  ball.grain = between(0.0, 0.12);
  ball.grain_px = between(2.0, 8.0);
  ball.line = PaintedLine{between(0.0, std::numbers::pi), between(0.03, 0.06) * diameter_px,
                          between(0.3, 0.8), between(-0.08, 0.08), between(0.5, 2.0)};
  ball.seam_contrast = between(0.0, 0.3);
  ball.seam_width_px = between(0.015, 0.03) * diameter_px;
  ball.seed = random();
  return ball;
}

PaintedBall next_image(const PaintedBall& ball, cv::Point2d centre, double turn_rad) {
  PaintedBall next = ball;
  next.centre = centre;
  if (next.line) next.line->angle_rad += turn_rad;
  return next;
}

}  // namespace strobe::testing
