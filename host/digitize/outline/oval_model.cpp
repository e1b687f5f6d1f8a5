#include "host/digitize/outline/oval_model.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

constexpr std::size_t kFewest = 5;
constexpr double kMinSd = 5e-4;  // no ball can be said to be rounder
constexpr double kMaxSd = 0.02;
constexpr double kSquareSd = 1e-3;  // pixels are nearly square
constexpr double kTukey2 = 4.685 * 4.685;
constexpr double kMedianOfSquares = 1.386;  // of two normal numbers' sum

double variance_of(const OvalSample& sample) { return 0.5 * cv::trace(sample.covariance); }

/// The variance beyond the samples' own that makes their squared residuals what they should be.
double extra_variance(std::span<const OvalSample> samples, const std::vector<double>& squares) {
  const auto middle = [&](double extra) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < samples.size(); ++i)
      ratios.push_back(squares[i] / (variance_of(samples[i]) + extra));
    return upper_median(std::move(ratios));
  };
  double low = kMinSd * kMinSd, high = kMaxSd * kMaxSd;
  if (middle(low) <= kMedianOfSquares) return low;
  for (int i = 0; i < 16; ++i) {
    const double half = std::sqrt(low * high);
    (middle(half) > kMedianOfSquares ? low : high) = half;
  }
  return high;
}

}  // namespace

cv::Matx23d OvalModel::terms(cv::Point2d plane_px) const {
  const cv::Point2d d = (plane_px - middle_) * (1.0 / reach_px_);
  return {1.0, 0.0, d.x * d.x - d.y * d.y, 0.0, 1.0, 2.0 * d.x * d.y};
}

cv::Vec2d OvalModel::at(cv::Point2d plane_px) const { return terms(plane_px) * unknowns_; }

std::optional<OvalModel> fit_oval_model(std::span<const OvalSample> samples, cv::Point2d middle,
                                        double reach_px) {
  if (samples.size() < kFewest) return std::nullopt;
  OvalModel agreed;
  agreed.middle_ = middle;
  agreed.reach_px_ = reach_px;
  std::vector<double> squares(samples.size());
  double extra = kMinSd * kMinSd;
  cv::Matx33d normal;
  for (int round = 0; round < 6; ++round) {
    normal = cv::Matx33d::zeros();
    normal(0, 0) = normal(1, 1) = 1.0 / (kSquareSd * kSquareSd);
    normal(2, 2) = 1.0 / (kMaxSd * kMaxSd);
    cv::Vec3d right;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double variance = variance_of(samples[i]) + extra;
      const double z2 = squares[i] / (variance * kTukey2);
      if (z2 >= 1.0) continue;
      const double weight = (1.0 - z2) * (1.0 - z2) / variance;
      const cv::Matx23d g = agreed.terms(samples[i].at);
      normal += weight * (g.t() * g);
      right += weight * (g.t() * samples[i].oval);
    }
    agreed.unknowns_ = normal.solve(right, cv::DECOMP_CHOLESKY);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const cv::Vec2d left = samples[i].oval - agreed.at(samples[i].at);
      squares[i] = left.dot(left);
    }
    extra = extra_variance(samples, squares);
  }
  const cv::Matx33d unsure = normal.inv(cv::DECOMP_CHOLESKY);
  agreed.sd_ = std::sqrt(extra + std::max(unsure(0, 0), unsure(1, 1)));
  return agreed;
}

}  // namespace strobe::digitize
