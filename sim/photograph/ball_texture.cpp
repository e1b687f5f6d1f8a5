#include "sim/photograph/ball_texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
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

}  // namespace

BallTexture::BallTexture(const BallAppearance& appearance, double radius_px)
    : albedo_(kSide, kSide, CV_32FC1, cv::Scalar(1.0)) {
  add_felt(appearance);
  if (appearance.surface == BallSurface::felt) {
    if (appearance.seam_contrast != 0.0) add_seams(appearance);
  } else if (appearance.seam_contrast != 0.0) {
    mark(appearance, radius_px);
  }
  if (appearance.logo_contrast != 0.0) print(appearance);
  if (appearance.surface == BallSurface::dimples) dent(appearance);
  add_hair(appearance);
  if (appearance.albedo != 1.0) albedo_ *= appearance.albedo;
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
    const Vec3 p = turn(seam_point(t));
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

void BallTexture::mark(const BallAppearance& appearance, double radius_px) {
  const BallMarkings markings(appearance.surface);
  const Turn turn(appearance.texture + 1);
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

}  // namespace strobe::sim
