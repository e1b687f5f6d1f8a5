#include "host/digitize/image/mosaic_light.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

/// The sum's blur has a variance of 1/2 px² in each direction, the smoothed own colour's of 2 px².
constexpr float kSharpness = 0.25F;
using Gains = std::array<float, 3>;

/// The sum over each colour's numbers, where there is light: most of it is the balls'. Their own noise is all
/// that more than fourfold ones would gain.
Gains gains_of(const cv::Mat& light, const cv::Mat& smooth, const image::Mosaic& mosaic, float scale) {
  constexpr int kStep = 7;  // odd, so that all colours come
  constexpr float kShareOfBright = 0.25F, kMaxGain = 4.0F;
  std::vector<float> sums;
  for (int y = 0; y < light.rows; y += kStep)
    for (int x = 0; x < light.cols; x += kStep) sums.push_back(light.at<float>(y, x));
  const float bright = kShareOfBright * quantile(std::move(sums), 99, 100);
  std::array<std::vector<float>, 3> ratios;
  for (int y = 0; y < light.rows; y += kStep) {
    for (int x = 0; x < light.cols; x += kStep) {
      const float all = light.at<float>(y, x);
      const float one = (smooth.at<float>(y, x) - static_cast<float>(mosaic.black)) * scale;
      if (all > bright && one > 0.0F) ratios[mosaic.colour(x, y)].push_back(all / one);
    }
  }
  Gains gains{1.0F, 1.0F, 1.0F};
  for (std::size_t colour = 0; colour < gains.size(); ++colour)
    if (!ratios[colour].empty()) gains[colour] = std::min(kMaxGain, upper_median(std::move(ratios[colour])));
  return gains;
}

/// The least light of pixels whose neighbours of one colour are all full: beyond it some colour's numbers are
/// cut off, and the sum with them. One that never was: 1.
float full_light(const cv::Mat& numbers, double full, const cv::Mat& light) {
  double largest = 0.0;
  cv::minMaxLoc(numbers, nullptr, &largest);
  if (largest < full) return 1.0F;
  cv::Mat count;
  cv::compare(numbers, full, count, cv::CMP_GE);
  cv::boxFilter(count & 1, count, CV_8U, {5, 5}, {-1, -1}, false, cv::BORDER_REFLECT_101);
  constexpr int kGreens = 12;  // at least, of 5 x 5: around those that the light is of
  std::vector<float> lights;
  for (int y = 0; y < light.rows; ++y)
    for (int x = 0; x < light.cols; ++x)
      if (count.at<std::uint8_t>(y, x) >= kGreens) lights.push_back(light.at<float>(y, x));
  constexpr std::size_t kMinLights = 20;
  return lights.size() < kMinLights ? 1.0F : quantile(std::move(lights), 1, 100);
}

}  // namespace

MosaicLight mosaic_light(const cv::Mat& numbers, const image::Mosaic& mosaic, double full) {
  const cv::Matx13f weights(0.25F, 0.5F, 0.25F);
  const cv::Matx<float, 1, 5> own_colour(0.25F, 0.0F, 0.5F, 0.0F, 0.25F);
  cv::Mat light, smooth;
  // Beyond the border as in a mirror on its pixels: there a pixel has the same colour.
  cv::sepFilter2D(numbers, light, CV_32F, weights, weights, {-1, -1}, 0.0, cv::BORDER_REFLECT_101);
  cv::sepFilter2D(numbers, smooth, CV_32F, own_colour, own_colour, {-1, -1}, 0.0, cv::BORDER_REFLECT_101);
  const auto black = static_cast<float>(mosaic.black);
  const float scale = 1.0F / static_cast<float>(mosaic.white - mosaic.black);
  light = (light - black) * scale;
  Gains gains = gains_of(light, smooth, mosaic, scale);
  for (float& gain : gains) gain *= kSharpness * scale;
  cv::parallel_for_({0, light.rows}, [&](const cv::Range& rows) {
    for (int y = rows.start; y < rows.end; ++y) {
      const auto* number = numbers.ptr<std::uint16_t>(y);
      const auto* own = smooth.ptr<float>(y);
      auto* row = light.ptr<float>(y);
      const std::array<float, 2> gain{gains[mosaic.colour(0, y)], gains[mosaic.colour(1, y)]};
      for (int x = 0; x < light.cols; ++x) {
        const float detail = static_cast<float>(number[x]) - own[x];
        row[x] = std::clamp(row[x] + gain[static_cast<std::size_t>(x % 2)] * detail, 0.0F, 1.0F);
      }
    }
  });
  const float most = full_light(numbers, full, light);
  cv::min(light, most, light);
  return {light, most};
}

}  // namespace strobe::digitize
