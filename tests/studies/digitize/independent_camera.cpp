#include "tests/studies/digitize/independent_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace strobe::studies::digitize {

namespace {

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

}  // namespace

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

}  // namespace strobe::studies::digitize
