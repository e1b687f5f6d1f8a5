// A mosaic's light: no pattern of colours, no edge moved, nothing cut off. What there should be is computed from the
// scene's light before the sensor.
#include "host/digitize/image/mosaic_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::digitize;

namespace {

using Colour = std::array<double, 3>;
constexpr int kSide = 64;
constexpr double kFull = 16383;
const Colour kYellow{0.39, 1.0, 0.18}, kWhite{0.5, 1.0, 0.67}, kRed{0.9, 0.2, 0.1};

image::Mosaic mosaic_with(const std::array<std::uint8_t, 4>& colours) { return {colours, 500, 16383}; }

/// light(x, y, colour) from 0 to 1.
template <typename Light>
cv::Mat sensed(const image::Mosaic& mosaic, const Light& light) {
  cv::Mat numbers(kSide, kSide, CV_16UC1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const double value = std::min(1.0, light(x, y, mosaic.colour(x, y)));
      numbers.at<std::uint16_t>(y, x) = cv::saturate_cast<std::uint16_t>(
          mosaic.black + value * (mosaic.white - mosaic.black));
    }
  return numbers;
}

double mixed(const Colour& colour) { return 0.25 * colour[0] + 0.5 * colour[1] + 0.25 * colour[2]; }

/// A step of light at `edge`, blurred by a lens.
double step(double x, double edge) { return 0.5 + 0.5 * std::erf((x - edge) / (0.8 * std::numbers::sqrt2)); }

constexpr std::array<std::array<std::uint8_t, 4>, 4> kPatterns{{{0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}}};

}  // namespace

TEST_GROUP(MosaicLight){};

// Rounding of the numbers is 3e-5 of the range; its sharpened part counts a quarter, times a gain of up to 4.
TEST(MosaicLight, OfThingsOfAnyColourHasNoPattern) {
  for (const auto& pattern : kPatterns) {
    const image::Mosaic mosaic = mosaic_with(pattern);
    for (const Colour& colour : {kYellow, kWhite, kRed}) {
      const auto [light, full] = mosaic_light(
          sensed(mosaic, [&](int, int, std::size_t c) { return 0.6 * colour[c]; }), mosaic, kFull);
      double least = 0.0, most = 0.0;
      cv::minMaxLoc(light, &least, &most);
      DOUBLES_EQUAL(0.6 * mixed(colour), least, 1e-4);
      DOUBLES_EQUAL(0.6 * mixed(colour), most, 1e-4);
      DOUBLES_EQUAL(1.0, full, 0.0);
    }
  }
}

// Where an edge is: from the sum of light across it, of two rows. A colour samples it every 2 px, which puts an edge of
// a blur of .8 px off by up to 2/pi·exp(-2 pi²·.8²/2²) = .027 px, here as there: along an edge that is not parallel to the
// pixels it averages out.
TEST(MosaicLight, HasItsEdgesWhereTheyAre) {
  for (const auto& pattern : kPatterns) {
    const image::Mosaic mosaic = mosaic_with(pattern);
    for (const Colour& colour : {kYellow, kWhite, kRed}) {
      for (const double edge : {31.0, 31.3, 31.5, 31.8, 32.2}) {
        const cv::Mat light =
            mosaic_light(sensed(mosaic, [&](int x, int, std::size_t c) { return 0.6 * colour[c] * step(x, edge); }),
                         mosaic, kFull)
                .light;
        double sum = 0.0;
        for (int y = 30; y < 32; ++y)
          for (int x = 8; x < 56; ++x) sum += 0.5 * light.at<float>(y, x);
        DOUBLES_EQUAL(edge, 55.5 - sum / (0.6 * mixed(colour)), 0.027);
      }
    }
  }
}

// Half-way up, a blurred step has the slope of its blur: of .8 px by the lens and .7 px by the sum alone, .75 of what the
// lens alone leaves. What comes back leaves terms of the fourth order.
TEST(MosaicLight, IsAsSharpAsThePicture) {
  const image::Mosaic mosaic = mosaic_with({0, 1, 1, 2});
  const cv::Mat light =
      mosaic_light(sensed(mosaic, [&](int x, int, std::size_t c) { return 0.6 * kYellow[c] * step(x, 31.5); }),
                   mosaic, kFull)
          .light;
  double slope = 0.0;
  for (int y = 30; y < 32; ++y) slope += 0.5 * (light.at<float>(y, 32) - light.at<float>(y, 31));
  const double sharp = step(32, 31.5) - step(31, 31.5);
  const double share = slope / (0.6 * mixed(kYellow)) / sharp;
  CHECK(share > 0.85 && share < 1.0);
}

TEST(MosaicLight, SaysFromWhereOnAColourIsFull) {
  const image::Mosaic mosaic = mosaic_with({0, 1, 1, 2});
  // A bright square in yellow light of 1.5: green is full, red and blue are not.
  const auto [light, full] = mosaic_light(sensed(mosaic,
                                                 [&](int x, int y, std::size_t c) {
                                                   const bool inside = x >= 20 && x < 44 && y >= 20 && y < 44;
                                                   return (inside ? 1.5 : 0.3) * kYellow[c];
                                                 }),
                                          mosaic, kFull);
  const double expected = 0.5 + 0.25 * 1.5 * (kYellow[0] + kYellow[2]);
  DOUBLES_EQUAL(expected, full, 1e-3);
  for (int y = 22; y < 42; ++y)
    for (int x = 22; x < 42; ++x) CHECK(light.at<float>(y, x) >= 0.999 * full);
  DOUBLES_EQUAL(0.3 * mixed(kYellow), light.at<float>(10, 10), 1e-4);
}

TEST(MosaicLight, OfTheDarkIsNoneHoweverItsNoiseFalls) {
  const image::Mosaic mosaic = mosaic_with({0, 1, 1, 2});
  cv::Mat numbers(kSide, kSide, CV_16UC1, cv::Scalar(500));
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) numbers.at<std::uint16_t>(y, x) += static_cast<std::uint16_t>((7 * x + 5 * y) % 9);
  numbers -= 4;
  const cv::Mat light = mosaic_light(numbers, mosaic, kFull).light;
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(light, &least, &most);
  CHECK(least >= 0.0);
  CHECK(most < 8.0 / (16383 - 500));
}
