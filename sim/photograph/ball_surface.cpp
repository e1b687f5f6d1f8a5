#include "sim/photograph/ball_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <string>

#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr int kSide = 384;
constexpr int kHair = 2048;
constexpr int kSeam_px = 5;  // of the map
constexpr int kDimples = 336;
constexpr double kDimple = 0.085;  // radius over the ball's
constexpr double kDent = 0.35;     // slope at its rim

double coordinate(int i) { return (2.0 * i + 1.0) / kSide - 1.0; }
double pixel(double x) { return 0.5 * ((x + 1.0) * kSide - 1.0); }

/// A random rotation.
class Turn {
 public:
  explicit Turn(std::uint64_t seed) {
    Draws draws(seed, Purpose::appearance, 1);
    double norm = 0.0;
    for (double& q : q_) {
      q = draws.normal();
      norm += q * q;
    }
    for (double& q : q_) q /= std::sqrt(norm);
  }
  Vec3 operator()(const Vec3& p) const {
    const auto [w, x, y, z] = q_;
    return {(1 - 2 * (y * y + z * z)) * p.x + 2 * (x * y - w * z) * p.y + 2 * (x * z + w * y) * p.z,
            2 * (x * y + w * z) * p.x + (1 - 2 * (x * x + z * z)) * p.y + 2 * (y * z - w * x) * p.z,
            2 * (x * z - w * y) * p.x + 2 * (y * z + w * x) * p.y + (1 - 2 * (x * x + y * y)) * p.z};
  }

 private:
  std::array<double, 4> q_{};
};

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

BallTexture::BallTexture(const BallAppearance& appearance)
    : albedo_(kSide, kSide, CV_32FC1, cv::Scalar(1.0)) {
  add_felt(appearance);
  if (appearance.seam_contrast != 0.0) add_seams(appearance);
  if (appearance.logo_contrast > 0.0) print(appearance);
  if (appearance.surface == BallSurface::dimples) dent(appearance);
  add_hair(appearance);
}

float BallTexture::lookup(const cv::Mat& map, double x, double y) {
  const double u = std::clamp(pixel(x), 0.0, kSide - 1.001);
  const double v = std::clamp(pixel(y), 0.0, kSide - 1.001);
  const int i = static_cast<int>(u);
  const int j = static_cast<int>(v);
  const auto a = static_cast<float>(u - i);
  const auto b = static_cast<float>(v - j);
  const float* row = map.ptr<float>(j);
  const float* next = map.ptr<float>(j + 1);
  const float below = row[i] + a * (row[i + 1] - row[i]);
  const float above = next[i] + a * (next[i + 1] - next[i]);
  return below + b * (above - below);
}

double BallTexture::hair_px(double angle_rad) const {
  if (hair_px_.empty()) return 0.0;
  const double turns = angle_rad / (2.0 * std::numbers::pi);
  const auto i = static_cast<int>((turns - std::floor(turns)) * kHair);
  return hair_px_[static_cast<std::size_t>(std::clamp(i, 0, kHair - 1))];
}

void BallTexture::add_felt(const BallAppearance& appearance) {
  if (appearance.grain == 0.0) return;
  // From half a ball to half a millimetre; an octave of value noise has an sd of .3 or so.
  const ValueNoise noise(appearance.texture);
  const double strength = appearance.grain / 0.36;
  cv::parallel_for_({0, kSide}, [&](const cv::Range& rows) {
    for (int j = rows.start; j < rows.end; ++j) {
      const double y = coordinate(j);
      float* row = albedo_.ptr<float>(j);
      for (int i = 0; i < kSide; ++i) {
        const double x = coordinate(i);
        const double z = std::sqrt(std::max(0.0, 1.0 - x * x - y * y));
        const double g = 0.5 * noise.at(3.0 * x, 3.0 * y, 3.0 * z) +
                         0.6 * noise.at(14.0 * x + 7.3, 14.0 * y, 14.0 * z) +
                         0.8 * noise.at(45.0 * x, 45.0 * y + 1.7, 45.0 * z);
        row[i] = static_cast<float>(std::clamp(1.0 + strength * g, 0.2, 1.5));
      }
    }
  });
}

void BallTexture::add_seams(const BallAppearance& appearance) {
  // The curve of two dumb-bells: x = a cos t + b cos 3t, y = a sin t - b sin 3t, z = 2 sqrt(ab) sin 2t.
  constexpr double a = 0.75, b = 0.25;
  constexpr int kPoints = 400;
  const Turn turn(appearance.texture + 1);
  cv::Mat seam(kSide, kSide, CV_8UC1, cv::Scalar(0));
  std::vector<cv::Point> piece;
  const auto draw = [&] {
    if (piece.size() > 1) cv::polylines(seam, piece, false, cv::Scalar(255), kSeam_px, cv::LINE_AA, 4);
    piece.clear();
  };
  for (int k = 0; k <= kPoints; ++k) {
    const double t = 2.0 * std::numbers::pi * k / kPoints;
    const Vec3 p = turn({a * std::cos(t) + b * std::cos(3 * t), a * std::sin(t) - b * std::sin(3 * t),
                         2.0 * std::sqrt(a * b) * std::sin(2 * t)});
    if (p.z < 0.0) {
      draw();
      continue;
    }
    piece.emplace_back(cvRound(16.0 * pixel(p.x)), cvRound(16.0 * pixel(p.y)));
  }
  draw();
  cv::GaussianBlur(seam, seam, {}, 1.2);
  for (int j = 0; j < kSide; ++j) {
    float* row = albedo_.ptr<float>(j);
    const std::uint8_t* ink = seam.ptr<std::uint8_t>(j);
    for (int i = 0; i < kSide; ++i)
      row[i] *= static_cast<float>(1.0 - appearance.seam_contrast * ink[i] / 255.0);
  }
}

void BallTexture::print(const BallAppearance& appearance) {
  Draws draws(appearance.texture, Purpose::appearance, 2);
  const double away = 0.65 * std::sqrt(draws.uniform());
  const double direction = 2.0 * std::numbers::pi * draws.uniform();
  const double turned_deg = 360.0 * draws.uniform();
  std::string word;
  const int letters = 2 + static_cast<int>(5.0 * draws.uniform());
  for (int k = 0; k < letters; ++k) word += static_cast<char>('A' + static_cast<int>(26.0 * draws.uniform()));
  const double height = 0.5 + 0.7 * draws.uniform();
  cv::Mat ink(kSide, kSide, CV_8UC1, cv::Scalar(0));
  const cv::Size size = cv::getTextSize(word, cv::FONT_HERSHEY_DUPLEX, height, 2, nullptr);
  cv::putText(ink, word, {(kSide - size.width) / 2, (kSide + size.height) / 2}, cv::FONT_HERSHEY_DUPLEX,
              height, cv::Scalar(255), 2, cv::LINE_AA);
  cv::flip(ink, ink, 0);  // the map's rows go up
  cv::Mat place = cv::getRotationMatrix2D({0.5F * kSide, 0.5F * kSide}, turned_deg, 1.0);
  place.at<double>(0, 2) += 0.5 * kSide * away * std::cos(direction);
  place.at<double>(1, 2) += 0.5 * kSide * away * std::sin(direction);
  cv::Mat placed;
  cv::warpAffine(ink, placed, place, ink.size());
  for (int j = 0; j < kSide; ++j) {
    float* row = albedo_.ptr<float>(j);
    const std::uint8_t* dark = placed.ptr<std::uint8_t>(j);
    for (int i = 0; i < kSide; ++i)
      row[i] *= static_cast<float>(1.0 - appearance.logo_contrast * dark[i] / 255.0);
  }
}

void BallTexture::dent(const BallAppearance& appearance) {
  tilt_x_ = cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(0.0));
  tilt_y_ = cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(0.0));
  const Turn turn(appearance.texture + 2);
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int k = 0; k < kDimples; ++k) {
    const double height = 1.0 - (2.0 * k + 1.0) / kDimples;
    const double flat = std::sqrt(1.0 - height * height);
    const Vec3 c = turn({flat * std::cos(golden * k), flat * std::sin(golden * k), height});
    if (c.z < -kDimple) continue;
    const int reach = static_cast<int>(kDimple * kSide / 2) + 2;
    for (int j = std::max(0, cvRound(pixel(c.y)) - reach);
         j <= std::min(kSide - 1, cvRound(pixel(c.y)) + reach); ++j) {
      for (int i = std::max(0, cvRound(pixel(c.x)) - reach);
           i <= std::min(kSide - 1, cvRound(pixel(c.x)) + reach); ++i) {
        const double x = coordinate(i), y = coordinate(j);
        if (x * x + y * y >= 1.0) continue;
        const Vec3 off = Vec3{x, y, std::sqrt(1.0 - x * x - y * y)} - c;
        const double share = std::sqrt(dot(off, off)) / kDimple;
        if (share >= 1.0) continue;
        // A hollow: the normal tilts towards the middle, and back at the rim.
        const double normal_tilt = -kDent * share * (1.0 - share * share) * 2.0;
        tilt_x_.at<float>(j, i) = static_cast<float>(normal_tilt * off.x / (kDimple * std::max(share, 0.1)));
        tilt_y_.at<float>(j, i) = static_cast<float>(normal_tilt * off.y / (kDimple * std::max(share, 0.1)));
      }
    }
  }
}

void BallTexture::add_hair(const BallAppearance& appearance) {
  if (appearance.hair_px == 0.0) return;
  // Waves of 4 to 99 a turn: none that moves the outline or makes it larger.
  constexpr int kLongest = 4, kShortest = 99;
  Draws draws(appearance.texture, Purpose::appearance, 3);
  std::vector<double> sum(kHair, 0.0);
  const double each = appearance.hair_px * std::sqrt(2.0 / (kShortest - kLongest + 1));
  for (int wave = kLongest; wave <= kShortest; ++wave) {
    const double phase = 2.0 * std::numbers::pi * draws.uniform();
    for (int i = 0; i < kHair; ++i)
      sum[static_cast<std::size_t>(i)] += each * std::cos(2.0 * std::numbers::pi * wave * i / kHair + phase);
  }
  hair_px_.assign(sum.begin(), sum.end());
}

struct BallLight::Placed {
  Vec3 centre;
  double cos = 1.0;  ///< of the line's angle
  double sin = 0.0;
  std::array<Vec3, 2> to_lamp;
  std::array<double, 2> strength{};
  double radius_px = 0.0;
  double surface_y = 0.0;
  bool flat = false;
};

BallLight::BallLight(const Scene& scene, const Appearance& appearance)
    : optics_(scene), appearance_(appearance), texture_(appearance.ball), radius_m_(scene.ball.radius_m()) {
  // The brightest place of a ball in the middle of the view under two lamps of the usual power.
  Placed ball = place({{0.0, 0.0, 0.0}, 0.0, {1.0, 1.0}});
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
  const double off_m = radius_m_ * std::abs(std::cos(tilt) * on_ball.y + std::sin(tilt) * on_ball.z);
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
  const Vec3 own{ball.cos * normal.x + ball.sin * normal.y, ball.cos * normal.y - ball.sin * normal.x,
                 normal.z};
  Vec3 lit = normal;
  if (texture_.has_relief()) {
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
  return level_ * light * texture_.albedo(own.x, own.y) * (1.0 - line_darkness(own));
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
  if (appearance_.ball.hair_px > 0.0)
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
