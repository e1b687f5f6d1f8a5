#include "host/digitize/overlay/display.hpp"

#include <algorithm>
#include <vector>

namespace strobe::digitize {
namespace {

float quantile_of(const std::vector<float>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace

cv::Mat display_grey(const cv::Mat& intensity, double white_number) {
  constexpr int kSamplesAcross = 400;
  const int step = std::max(1, std::max(intensity.cols, intensity.rows) / kSamplesAcross);
  std::vector<float> samples;
  for (int row = 0; row < intensity.rows; row += step) {
    for (int column = 0; column < intensity.cols; column += step)
      samples.push_back(intensity.at<float>(row, column));
  }
  std::ranges::sort(samples);
  const float black = quantile_of(samples, 0.01);
  const float white = std::max(quantile_of(samples, 0.998), black + 1e-4F);
  cv::Mat shown = (intensity - black) * (1.0F / (white - black));
  shown = cv::min(cv::max(shown, 0.0F), 1.0F);
  cv::sqrt(shown, shown);
  cv::Mat grey;
  shown.convertTo(grey, CV_8U, white_number);
  return grey;
}

}  // namespace strobe::digitize
