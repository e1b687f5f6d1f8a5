#include "sim/photograph/ball_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>

#include "sim/photograph/ball_markings.hpp"
#include "sim/random/draws.hpp"

namespace strobe::sim {

namespace {

constexpr int kSide = 384;
constexpr int kHair = 2048;
constexpr int kSeam_px = 5;  // of the map
constexpr int kDimples = 336;
constexpr double kDimple = 0.085;  // radius over the ball's
constexpr double kDent = 0.35;     // slope at its rim

constexpr double kReach = 0.4;  // of a side's axis: more than its corners' 1/sqrt(3)

double coordinate(int i) { return (2.0 * i + 1.0) / kSide - 1.0; }
double pixel(double x) { return 0.5 * ((x + 1.0) * kSide - 1.0); }

/// A random rotation.
class RandomTurn {
 public:
  explicit RandomTurn(std::uint64_t seed) {
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

/// Relative albedo of felt: from half a ball to half a millimetre; an octave of value noise has an sd of .3
/// or so.
float felt(const ValueNoise& noise, double strength, double x, double y, double z) {
  const double g = 0.5 * noise.at(3.0 * x, 3.0 * y, 3.0 * z) +
                   0.6 * noise.at(14.0 * x + 7.3, 14.0 * y, 14.0 * z) +
                   0.8 * noise.at(45.0 * x, 45.0 * y + 1.7, 45.0 * z);
  return static_cast<float>(std::clamp(1.0 + strength * g, 0.2, 1.5));
}

double felt_strength(const BallAppearance& appearance) { return appearance.grain / 0.36; }

void darken(cv::Mat& albedo, const cv::Mat& ink, double contrast) {
  for (int j = 0; j < kSide; ++j) {
    float* row = albedo.ptr<float>(j);
    const std::uint8_t* dark = ink.ptr<std::uint8_t>(j);
    for (int i = 0; i < kSide; ++i) row[i] *= static_cast<float>(1.0 - contrast * dark[i] / 255.0);
  }
}

/// `place`: of a direction on the map; nullopt where it is not on it.
template <typename Place>
void sew(cv::Mat& albedo, const BallAppearance& appearance, const Place& place) {
  constexpr int kPoints = 400;
  const RandomTurn turn(appearance.texture + 1);
  cv::Mat seam(kSide, kSide, CV_8UC1, cv::Scalar(0));
  std::vector<cv::Point> piece;
  const auto draw = [&] {
    if (piece.size() > 1) cv::polylines(seam, piece, false, cv::Scalar(255), kSeam_px, cv::LINE_AA, 4);
    piece.clear();
  };
  for (int k = 0; k <= kPoints; ++k) {
    const double t = 2.0 * std::numbers::pi * k / kPoints;
    const std::optional<Vec2> p = place(turn(seam_point(t)));
    if (!p) {
      draw();
      continue;
    }
    piece.emplace_back(cvRound(16.0 * pixel(p->x)), cvRound(16.0 * pixel(p->y)));
  }
  draw();
  cv::GaussianBlur(seam, seam, {}, 1.2);
  darken(albedo, seam, appearance.seam_contrast);
}

// A side of the cube: an axis (side % 3), and which of its ends.

double end_of(int side) { return side < 3 ? 1.0 : -1.0; }
std::array<double, 3> parts(const Vec3& p) { return {p.x, p.y, p.z}; }

/// Of length 1.
Vec3 direction_on(int side, double u, double v) {
  const double shrink = 1.0 / std::sqrt(1.0 + u * u + v * v);
  std::array<double, 3> p{};
  p[static_cast<std::size_t>(side % 3)] = shrink * end_of(side);
  p[static_cast<std::size_t>((side + 1) % 3)] = shrink * u;
  p[static_cast<std::size_t>((side + 2) % 3)] = shrink * v;
  return {p[0], p[1], p[2]};
}

std::optional<Vec2> place_on(int side, const Vec3& direction) {
  const std::array<double, 3> p = parts(direction);
  const double height = end_of(side) * p[static_cast<std::size_t>(side % 3)];
  if (height < kReach) return std::nullopt;
  return Vec2{p[static_cast<std::size_t>((side + 1) % 3)] / height,
              p[static_cast<std::size_t>((side + 2) % 3)] / height};
}

int side_of(const Vec3& direction) {
  const std::array<double, 3> p = parts(direction);
  int axis = std::abs(p[1]) > std::abs(p[0]) ? 1 : 0;
  if (std::abs(p[2]) > std::abs(p[static_cast<std::size_t>(axis)])) axis = 2;
  return p[static_cast<std::size_t>(axis)] < 0.0 ? axis + 3 : axis;
}

void print(cv::Mat& albedo, const BallAppearance& appearance) {
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
  darken(albedo, placed, appearance.logo_contrast);
}

/// The normal's tilt at `off` from a hollow's middle: towards it, and back at the rim. Nullopt outside.
std::optional<Vec3> hollow(const Vec3& off) {
  const double share = std::sqrt(dot(off, off)) / kDimple;
  if (share >= 1.0) return std::nullopt;
  const double tilt = -kDent * share * (1.0 - share * share) * 2.0;
  const double per = kDimple * std::max(share, 0.1);
  return Vec3{tilt * off.x / per, tilt * off.y / per, tilt * off.z / per};
}

}  // namespace

BallTexture::BallTexture(const BallAppearance& appearance, double radius_px, bool all_around)
    : albedo_(kSide, kSide, CV_32FC1, cv::Scalar(1.0)) {
  add_felt(appearance);
  if (appearance.surface == BallSurface::felt) {
    if (appearance.seam_contrast != 0.0) add_seams(appearance);
  } else if (appearance.seam_contrast != 0.0) {
    mark(appearance, radius_px);
  }
  if (appearance.logo_contrast != 0.0) print(albedo_, appearance);
  if (appearance.surface == BallSurface::dimples) dent(appearance);
  add_hair(appearance);
  if (appearance.albedo != 1.0) albedo_ *= appearance.albedo;
  if (all_around) cover(appearance);
}

void BallTexture::cover(const BallAppearance& appearance) {
  const ValueNoise noise(appearance.texture);
  const double strength = felt_strength(appearance);
  const BallMarkings markings(appearance.surface);
  const RandomTurn turn(appearance.texture + 1);
  const bool seams = appearance.surface == BallSurface::felt;
  for (int side = 0; side < 6; ++side) {
    cv::Mat& map = sides_[static_cast<std::size_t>(side)];
    map = cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(appearance.albedo));
    cv::parallel_for_({0, kSide}, [&](const cv::Range& rows) {
      for (int j = rows.start; j < rows.end; ++j) {
        float* row = map.ptr<float>(j);
        for (int i = 0; i < kSide; ++i) {
          const Vec3 p = direction_on(side, coordinate(i), coordinate(j));
          if (strength != 0.0) row[i] *= felt(noise, strength, p.x, p.y, p.z);
          if (!seams && appearance.seam_contrast != 0.0)
            row[i] *= static_cast<float>(1.0 - appearance.seam_contrast * markings.ink(turn(p)));
        }
      }
    });
    if (seams && appearance.seam_contrast != 0.0)
      sew(map, appearance, [side](const Vec3& p) { return place_on(side, p); });
  }
  constexpr std::size_t kFront = 2;  // towards z, where the hemisphere's print is, too
  if (appearance.logo_contrast != 0.0) print(sides_[kFront], appearance);
}

double BallTexture::albedo(const Vec3& direction) const {
  const int side = side_of(direction);
  const Vec2 at = place_on(side, direction).value_or(Vec2{});
  return lookup(sides_[static_cast<std::size_t>(side)], at.x, at.y);
}

Vec3 BallTexture::normal_tilt(const Vec3& direction) const {
  for (const Vec3& middle : dimples_) {
    if (dot(direction, middle) < 0.9) continue;  // two dimples away
    if (const auto tilt = hollow(direction - middle)) return *tilt;
  }
  return {};
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
  const ValueNoise noise(appearance.texture);
  const double strength = felt_strength(appearance);
  cv::parallel_for_({0, kSide}, [&](const cv::Range& rows) {
    for (int j = rows.start; j < rows.end; ++j) {
      const double y = coordinate(j);
      float* row = albedo_.ptr<float>(j);
      for (int i = 0; i < kSide; ++i) {
        const double x = coordinate(i);
        const double z = std::sqrt(std::max(0.0, 1.0 - x * x - y * y));
        row[i] = felt(noise, strength, x, y, z);
      }
    }
  });
}

void BallTexture::add_seams(const BallAppearance& appearance) {
  sew(albedo_, appearance, [](const Vec3& p) {
    return p.z < 0.0 ? std::nullopt : std::optional(Vec2{p.x, p.y});
  });
}

void BallTexture::mark(const BallAppearance& appearance, double radius_px) {
  const BallMarkings markings(appearance.surface);
  const RandomTurn turn(appearance.texture + 1);
  cv::parallel_for_({0, kSide}, [&](const cv::Range& rows) {
    for (int j = rows.start; j < rows.end; ++j) {
      const double y = coordinate(j);
      float* row = albedo_.ptr<float>(j);
      for (int i = 0; i < kSide; ++i) {
        const double x = coordinate(i), square = x * x + y * y;
        // Beyond the outline as on it.
        const double shrink = square > 1.0 ? 1.0 / std::sqrt(square) : 1.0;
        const Vec3 p{shrink * x, shrink * y, std::sqrt(std::max(0.0, 1.0 - square))};
        row[i] *= static_cast<float>(1.0 - appearance.seam_contrast * markings.ink(turn(p)));
      }
    }
  });
  if (appearance.surface != BallSurface::holes) return;
  hair_px_.assign(kHair, 0.0F);
  for (int i = 0; i < kHair; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kHair;
    const double edge =
        markings.edge_beyond(turn({std::cos(angle), std::sin(angle), 0.0}), turn({0.0, 0.0, 1.0}));
    hair_px_[static_cast<std::size_t>(i)] = static_cast<float>(radius_px * (edge - 1.0));
  }
}

void BallTexture::dent(const BallAppearance& appearance) {
  tilt_x_ = cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(0.0));
  tilt_y_ = cv::Mat(kSide, kSide, CV_32FC1, cv::Scalar(0.0));
  const RandomTurn turn(appearance.texture + 2);
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (int k = 0; k < kDimples; ++k) {
    const double height = 1.0 - (2.0 * k + 1.0) / kDimples;
    const double flat = std::sqrt(1.0 - height * height);
    const Vec3 c = turn({flat * std::cos(golden * k), flat * std::sin(golden * k), height});
    dimples_.push_back(c);
    if (c.z < -kDimple) continue;
    const int reach = static_cast<int>(kDimple * kSide / 2) + 2;
    for (int j = std::max(0, cvRound(pixel(c.y)) - reach);
         j <= std::min(kSide - 1, cvRound(pixel(c.y)) + reach); ++j) {
      for (int i = std::max(0, cvRound(pixel(c.x)) - reach);
           i <= std::min(kSide - 1, cvRound(pixel(c.x)) + reach); ++i) {
        const double x = coordinate(i), y = coordinate(j);
        if (x * x + y * y >= 1.0) continue;
        const auto tilt = hollow(Vec3{x, y, std::sqrt(1.0 - x * x - y * y)} - c);
        if (!tilt) continue;
        tilt_x_.at<float>(j, i) = static_cast<float>(tilt->x);
        tilt_y_.at<float>(j, i) = static_cast<float>(tilt->y);
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

}  // namespace strobe::sim
