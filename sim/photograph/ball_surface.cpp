#include "sim/photograph/ball_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::sim {

namespace {

constexpr int kGrid = 4;
constexpr double kShineExponent = 40.0;

Vec3 unit(const Vec3& a) { return (1.0 / std::sqrt(dot(a, a))) * a; }

struct Box {
  int left = 0, right = 0, top = 0, bottom = 0;  ///< ends are inside
};

Box box_of(const std::vector<Vec2>& outline, double margin, const SensorSize& sensor) {
  double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  for (const Vec2& p : outline) {
    left = std::min(left, p.x);
    right = std::max(right, p.x);
    top = std::min(top, p.y);
    bottom = std::max(bottom, p.y);
  }
  const auto within = [](double x, int size) {
    return static_cast<int>(std::clamp(std::floor(x), -1.0, static_cast<double>(size)));
  };
  return {std::max(0, within(left - margin, sensor.width)),
          std::min(sensor.width - 1, within(right + margin + 1.0, sensor.width)),
          std::max(0, within(top - margin, sensor.height)),
          std::min(sensor.height - 1, within(bottom + margin + 1.0, sensor.height))};
}

}  // namespace

struct BallLight::Placed {
  Vec3 centre;
  double cos = 1.0;  ///< of the line's angle
  double sin = 0.0;
  std::array<Vec3, 2> to_lamp;
  std::array<double, 2> strength{};
  double radius_px = 0.0;
  double surface_y = 0.0;
  bool flat = false;
  std::optional<Eigen::Matrix3d> attitude;  ///< of a ball that has turned about another axis than z

  /// To the ball's own axes, and back.
  Vec3 own(const Vec3& v) const {
    if (!attitude) return {cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z};
    const Eigen::Vector3d o = attitude->transpose() * Eigen::Vector3d(v.x, v.y, v.z);
    return {o.x(), o.y(), o.z()};
  }
  Vec3 from_own(const Vec3& v) const {
    const Eigen::Vector3d o = *attitude * Eigen::Vector3d(v.x, v.y, v.z);
    return {o.x(), o.y(), o.z()};
  }
};

BallLight::BallLight(const Scene& scene, const Appearance& appearance)
    : optics_(scene),
      appearance_(appearance),
      texture_(appearance.ball, scene.ball.radius_m() * scene.camera.px_per_m, !scene.machine.planar()),
      radius_m_(scene.ball.radius_m()) {
  // The brightest place of a ball in the middle of the view under two lamps of the usual power.
  Placed ball = place({{0.0, 0.0, 0.0}, 0.0, {1.0, 1.0}, {}});
  constexpr int kSteps = 40;
  double most = 0.0;
  for (int i = -kSteps; i <= kSteps; ++i) {
    for (int j = -kSteps; j <= kSteps; ++j) {
      const double x = 0.99 * i / kSteps, y = 0.99 * j / kSteps;
      if (x * x + y * y >= 0.98) continue;
      const Vec3 n{x, y, std::sqrt(1.0 - x * x - y * y)};
      double sum = 0.0;
      for (std::size_t lamp = 0; lamp < 2; ++lamp) {
        const double mu = dot(n, ball.to_lamp[lamp]);
        if (mu > 0.0) sum += std::pow(mu, appearance_.ball.falloff);
      }
      most = std::max(most, sum);
    }
  }
  level_ = 1.0 / most;
}

BallLight::Placed BallLight::place(const LitBall& ball) const {
  Placed p;
  p.centre = ball.centre;
  p.cos = std::cos(ball.angle_rad);
  p.sin = std::sin(ball.angle_rad);
  if (ball.turned) {
    p.attitude = ball.attitude();
    // As far as the outline's irregularities turn with it.
    const double angle_rad = std::atan2((*p.attitude)(1, 0), (*p.attitude)(0, 0));
    p.cos = std::cos(angle_rad);
    p.sin = std::sin(angle_rad);
  }
  for (std::size_t lamp = 0; lamp < 2; ++lamp) {
    const Vec3 way = appearance_.lamps[lamp].place - ball.centre;
    const double usual = dot(appearance_.lamps[lamp].place, appearance_.lamps[lamp].place);
    p.to_lamp[lamp] = unit(way);
    p.strength[lamp] = ball.light[lamp] * usual / dot(way, way);
  }
  const double nearer =
      optics_.perspective() ? optics_.distance_m() / (optics_.distance_m() - ball.centre.z) : 1.0;
  p.radius_px = nearer * radius_m_ * optics_.px_per_m();
  p.surface_y = optics_.surface_y();
  p.flat = ball.centre.y - radius_m_ < p.surface_y + 2.0 / optics_.px_per_m();
  return p;
}

double BallLight::line_darkness(const Vec3& on_ball) const {
  if (!appearance_.ball.line) return 0.0;
  const double tilt = appearance_.ball.line_tilt_rad;
  const double off_m = radius_m_ * std::abs(std::cos(tilt) * on_ball.y + std::sin(tilt) * on_ball.z -
                                            appearance_.ball.line_offset);
  const double share = 2.0 * off_m / appearance_.ball.line_width_m;
  if (share > 6.0) return 0.0;
  return appearance_.ball.line_contrast * std::exp2(-std::pow(share, appearance_.ball.line_steepness));
}

double BallLight::lamp_light(const Vec3& normal, const Vec3& to_lamp, double towards_lens,
                             const Vec3& to_lens) const {
  const double mu = dot(normal, to_lamp);
  if (mu <= 0.0) return 0.0;
  const double away = 1.0 - towards_lens;
  double light =
      std::pow(mu, appearance_.ball.falloff) + appearance_.ball.sheen * away * away * std::sqrt(mu);
  if (appearance_.ball.shine > 0.0) {
    const Vec3 between = unit(to_lamp + to_lens);
    light += appearance_.ball.shine * std::pow(std::max(0.0, dot(normal, between)), kShineExponent);
  }
  return light;
}

double BallLight::shade(const Placed& ball, const Vec3& normal, const Vec3& to_lens) const {
  const Vec3 own = ball.own(normal);
  Vec3 lit = normal;
  if (ball.attitude) {
    if (texture_.has_relief()) lit = unit(normal + ball.from_own(texture_.normal_tilt(own)));
  } else if (texture_.has_relief()) {
    const Vec2 normal_tilt = texture_.normal_tilt(own.x, own.y);
    lit = unit({normal.x + ball.cos * normal_tilt.x - ball.sin * normal_tilt.y,
                normal.y + ball.sin * normal_tilt.x + ball.cos * normal_tilt.y, normal.z});
  }
  const double towards_lens = std::max(0.0, dot(normal, to_lens));
  double light = 0.0;
  for (std::size_t lamp = 0; lamp < 2; ++lamp) {
    if (ball.strength[lamp] > 0.0)
      light += ball.strength[lamp] * lamp_light(lit, ball.to_lamp[lamp], towards_lens, to_lens);
  }
  const double albedo = ball.attitude ? texture_.albedo(own) : texture_.albedo(own.x, own.y);
  return level_ * light * albedo * (1.0 - line_darkness(own));
}

/// `width_px`: over which a sample's own coverage falls at an edge.
BallLight::Sample BallLight::sample(const Placed& ball, double column, double row, double width_px) const {
  const Vec2 p = optics_.plane_at(column, row);
  Vec3 to_lens{0.0, 0.0, 1.0};
  if (optics_.perspective()) to_lens = unit({-p.x, -p.y, optics_.distance_m()});
  // From the ball's centre to the nearest point of the ray.
  const Vec3 way = Vec3{p.x, p.y, 0.0} - ball.centre;
  const Vec3 aside = way - dot(way, to_lens) * to_lens;
  const double share = std::sqrt(dot(aside, aside)) / radius_m_;
  double hair = 0.0;
  if (texture_.has_hair())
    hair = texture_.hair_px(std::atan2(aside.y, aside.x) - std::atan2(ball.sin, ball.cos));
  const double outside_px = (share - 1.0) * ball.radius_px - hair;
  const double fade_px = std::max(width_px, 2.0 * appearance_.ball.fuzz_px);
  double coverage = std::clamp(0.5 - outside_px / fade_px, 0.0, 1.0);
  if (coverage <= 0.0) return {};
  const double depth = share < 1.0 ? std::sqrt(1.0 - share * share) : 0.0;
  const Vec3 normal = unit((1.0 / radius_m_) * aside + depth * to_lens);
  if (ball.flat) {
    const double over_px = (ball.centre.y + radius_m_ * normal.y - ball.surface_y) * optics_.px_per_m();
    coverage *= std::clamp(0.5 + over_px / width_px, 0.0, 1.0);
    if (coverage <= 0.0) return {};
  }
  return {coverage, shade(ball, normal, to_lens)};
}

BallLight::Sample BallLight::pixel(const Placed& ball, int column, int row) const {
  Sample sum;
  for (int i = 0; i < kGrid; ++i) {
    for (int j = 0; j < kGrid; ++j) {
      const Sample s =
          sample(ball, column + (i + 0.5) / kGrid - 0.5, row + (j + 0.5) / kGrid - 0.5, 1.0 / kGrid);
      sum.coverage += s.coverage;
      sum.light += s.coverage * s.light;
    }
  }
  constexpr double kShare = 1.0 / (kGrid * kGrid);
  return {kShare * sum.coverage, kShare * sum.light};
}

void BallLight::add(const LitBall& lit, const cv::Mat& behind, double hidden, int first, int end,
                    cv::Mat& light) const {
  const Placed ball = place(lit);
  const double rim_px = 1.5 + appearance_.ball.fuzz_px + 5.0 * appearance_.ball.hair_px;
  const Box box =
      box_of(outline_on_sensor(optics_, ball.centre, radius_m_, 64), rim_px + 1.0, optics_.sensor());
  for (int row = std::max(first, box.top); row < std::min(end, box.bottom + 1); ++row) {
    float* sum = light.ptr<float>(row);
    const float* back = behind.ptr<float>(row);
    for (int column = box.left; column <= box.right; ++column) {
      const Vec2 p = optics_.plane_at(column, row);
      Vec3 to_lens{0.0, 0.0, 1.0};
      if (optics_.perspective()) to_lens = unit({-p.x, -p.y, optics_.distance_m()});
      const Vec3 way = Vec3{p.x, p.y, 0.0} - ball.centre;
      const Vec3 aside = way - dot(way, to_lens) * to_lens;
      const double outside_px = std::sqrt(dot(aside, aside)) / radius_m_ * ball.radius_px - ball.radius_px;
      if (outside_px > rim_px) continue;
      const double over_px = (ball.centre.y + aside.y - ball.surface_y) * optics_.px_per_m();
      const bool edge = outside_px > -rim_px || (ball.flat && over_px < 0.3 * ball.radius_px + 2.0);
      const Sample s = edge ? pixel(ball, column, row) : sample(ball, column, row, 1.0);
      const double b = static_cast<double>(back[column]);
      const double covered_light = edge ? s.light : s.coverage * s.light;
      sum[column] += static_cast<float>(covered_light - s.coverage * hidden * b);
    }
  }
}

}  // namespace strobe::sim
