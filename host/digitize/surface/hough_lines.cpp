#include "host/digitize/surface/hough_lines.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr double kMaxSlope = 0.36;  // 20 degrees
constexpr int kSlopes = 145;
constexpr double kSlopeStep = 2.0 * kMaxSlope / (kSlopes - 1);
constexpr int kVoteReach = 8;  // slopes to either side of an edge point's own
constexpr int kSmallWidth = 720;

double hough_scale(cv::Size photograph) {
  return std::max(1.0, static_cast<double>(photograph.width) / kSmallWidth);
}

/// Noise level of the gradients, from their distribution.
float typical_edge(const cv::Mat& gradient) {
  std::vector<float> values;
  for (int row = 0; row < gradient.rows; row += 2) {
    const auto* g = gradient.ptr<float>(row);
    for (int column = 0; column < gradient.cols; column += 2) values.push_back(std::abs(g[column]));
  }
  return std::max(quantile(std::move(values), 7, 10), 1e-6F);
}

class Accumulator {
 public:
  explicit Accumulator(const cv::Mat& light) : size_(light.size()) {
    reach_ = static_cast<int>(std::ceil(0.5 * kMaxSlope * size_.width)) + 2;
    rows_ = size_.height + 2 * reach_;
    votes_ = cv::Mat::zeros(kSlopes, rows_, CV_32FC1);
  }

  void add(double column, double row, double slope, float weight) {
    const int middle = static_cast<int>(std::lround((slope + kMaxSlope) / kSlopeStep));
    for (int k = std::max(0, middle - kVoteReach); k <= std::min(kSlopes - 1, middle + kVoteReach); ++k) {
      const double at = row - (k * kSlopeStep - kMaxSlope) * (column - 0.5 * size_.width) + reach_;
      const int bin = static_cast<int>(at);
      if (bin < 0 || bin + 1 >= rows_) continue;
      const auto part = static_cast<float>(at - bin);
      float* v = votes_.ptr<float>(k);
      v[bin] += weight * (1.0F - part);
      v[bin + 1] += weight * part;
    }
  }

  std::vector<HoughLine> best(std::size_t max_lines, double scale) {
    std::vector<HoughLine> lines;
    while (lines.size() < max_lines) {
      double top = 0.0;
      cv::Point at;
      cv::minMaxLoc(votes_, nullptr, &top, nullptr, &at);
      if (top < 0.04 * size_.width) break;
      HoughLine line;
      line.slope = at.y * kSlopeStep - kMaxSlope;
      line.row_px = (at.x - reach_ + 0.5) * scale - 0.5;
      line.votes = top / size_.width;
      lines.push_back(line);
      clear_around(at);
    }
    return lines;
  }

 private:
  void clear_around(cv::Point at) {
    for (int k = std::max(0, at.y - 6); k <= std::min(kSlopes - 1, at.y + 6); ++k) {
      float* v = votes_.ptr<float>(k);
      for (int bin = std::max(0, at.x - 2); bin <= std::min(rows_ - 1, at.x + 2); ++bin) v[bin] = 0.0F;
    }
  }

  cv::Size size_;
  int reach_ = 0, rows_ = 0;
  cv::Mat votes_;
};

}  // namespace

cv::Size hough_image_size(cv::Size photograph) {
  const double scale = hough_scale(photograph);
  return {std::max(8, static_cast<int>(std::lround(photograph.width / scale))),
          std::max(8, static_cast<int>(std::lround(photograph.height / scale)))};
}

std::vector<HoughLine> hough_lines(const Photograph& photograph, const OcclusionMask& occluded,
                                   std::size_t max_lines) {
  cv::Mat light, smooth, gx, gy;
  cv::resize(photograph.intensity, light, hough_image_size(photograph.intensity.size()), 0, 0,
             cv::INTER_AREA);
  cv::GaussianBlur(light, smooth, {}, 1.0);
  cv::Scharr(smooth, gx, CV_32F, 1, 0, 1.0 / 32.0);
  cv::Scharr(smooth, gy, CV_32F, 0, 1, 1.0 / 32.0);
  const float edge = 3.0F * typical_edge(gy);
  Accumulator votes(light);
  for (int row = 2; row + 2 < gy.rows; ++row) {
    const auto* x = gx.ptr<float>(row);
    const auto* y = gy.ptr<float>(row);
    const auto* above = gy.ptr<float>(row - 1);
    const auto* below = gy.ptr<float>(row + 1);
    const uchar* mask = occluded.mask.empty() ? nullptr : occluded.mask.ptr<uchar>(row);
    for (int column = 2; column + 2 < gy.cols; ++column) {
      if (y[column] < edge || y[column] < above[column] || y[column] <= below[column]) continue;
      if (mask != nullptr && mask[column] != 0) continue;
      const double slope = -x[column] / y[column];
      if (std::abs(slope) > kMaxSlope + kVoteReach * kSlopeStep) continue;
      const double bend = above[column] - 2.0 * y[column] + below[column];
      const double part = bend < 0.0 ? 0.5 * (above[column] - below[column]) / bend : 0.0;
      votes.add(column, row + part, slope, std::min(1.0F, y[column] / (2.0F * edge)));
    }
  }
  return votes.best(max_lines, hough_scale(photograph.intensity.size()));
}

}  // namespace strobe::digitize
