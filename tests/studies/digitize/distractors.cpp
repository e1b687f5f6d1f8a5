#include "tests/studies/digitize/distractors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <random>
#include <utility>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::studies::digitize {

namespace {

struct Disc {
  cv::Point2d centre;  // image px
  double radius = 0.0, light = 0.0;
};

/// Light at a place of a disc, by how far it is from the middle, 0 to 1, and in which direction.
template <class Shade>
void draw(const Disc& disc, const Shade& shade, cv::Mat& light) {
  constexpr double kBlur_px = 1.0;
  const double reach = disc.radius + 4.0 * kBlur_px;
  const cv::Rect box = cv::Rect(cv::Point(cvFloor(disc.centre.x - reach), cvFloor(disc.centre.y - reach)),
                                cv::Point(cvCeil(disc.centre.x + reach), cvCeil(disc.centre.y + reach))) &
                       cv::Rect(0, 0, light.cols, light.rows);
  for (int row = box.y; row < box.y + box.height; ++row) {
    for (int column = box.x; column < box.x + box.width; ++column) {
      const double x = column - disc.centre.x, y = row - disc.centre.y, from = std::hypot(x, y);
      const double inside = 0.5 * std::erfc((from - disc.radius) / (std::numbers::sqrt2 * kBlur_px));
      light.at<float>(row, column) += static_cast<float>(
          disc.light * inside * shade(std::min(1.0, from / disc.radius), std::atan2(y, x)));
    }
  }
}

double dome(double share) { return std::sqrt(std::max(0.0, 1.0 - share * share)); }

void add_round_thing(const Disc& disc, std::mt19937_64& random, cv::Mat& light) {
  const double turn = std::uniform_real_distribution(-std::numbers::pi, std::numbers::pi)(random);
  switch (std::uniform_int_distribution(0, 3)(random)) {
    case 0: return draw(disc, [](double, double) { return 1.0; }, light);
    case 1:  // a sphere that a lamp lights from the side
      return draw(disc, [&](double share, double angle) {
        return std::max(0.0, 0.6 * dome(share) + 0.6 * share * std::cos(angle - turn));
      }, light);
    case 2: return draw(disc, [](double share, double) { return share > 0.85 ? 1.0 : 0.0; }, light);
    default:  // an arc of four fifths of a half circle
      return draw(disc, [&](double share, double angle) {
        return share > 0.8 && std::cos(angle - turn) > 0.3 ? 1.0 : 0.0;
      }, light);
  }
}

double median_diameter(std::span<const TrueImage> truth) {
  std::vector<double> all;
  for (const TrueImage& image : truth) all.push_back(image.diameter_px);
  return strobe::digitize::upper_median(std::move(all));
}

void add_texture(double sd, double diameter, std::mt19937_64& random, cv::Mat& light) {
  constexpr std::array<double, 4> kScales{0.05, 0.2, 0.7, 2.0};  // of the ball's diameter
  for (const double scale : kScales) {
    const double px = std::max(1.0, scale * diameter);
    cv::Mat coarse(std::max(4, cvCeil(light.rows / px)), std::max(4, cvCeil(light.cols / px)), CV_32FC1);
    cv::Mat fine;
    std::normal_distribution<float> normal(0.0F, static_cast<float>(sd / std::sqrt(kScales.size())));
    for (float& each : cv::Mat_<float>(coarse)) each = normal(random);
    cv::resize(coarse, fine, light.size(), 0, 0, cv::INTER_CUBIC);
    light += fine;
  }
  light += 2.0 * sd;  // seldom darker than without
}

}  // namespace

void add_distractors(const Distractors& distractors, std::uint64_t seed, double ball_light,
                     std::span<const TrueImage> truth, strobe::digitize::Photograph& photograph) {
  if (!distractors.any() || truth.empty()) return;
  std::mt19937_64 random(seed);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  cv::Mat& light = photograph.intensity;
  const double diameter = median_diameter(truth);
  if (distractors.texture > 0.0) add_texture(distractors.texture * ball_light, diameter, random, light);
  for (int i = 0; i < distractors.round_things; ++i) {
    const cv::Point2d at(in(0.0, light.cols), in(0.0, light.rows));
    add_round_thing({at, 0.5 * diameter * in(0.85, 1.15), ball_light * in(0.1, 0.9)}, random, light);
  }
  for (std::size_t i = 0; distractors.trail > 0.0 && i + 1 < truth.size(); ++i) {
    for (const double share : {0.35, 0.7}) {
      const auto &a = truth[i].centre_px, &b = truth[i + 1].centre_px;
      draw({{a.x + share * (b.x - a.x), light.rows - 1.0 - (a.y + share * (b.y - a.y))}, 0.5 * diameter,
            distractors.trail * ball_light},
           [](double from, double) { return dome(from); }, light);
    }
  }
  light = cv::min(light, photograph.saturation);
}

}  // namespace strobe::studies::digitize
