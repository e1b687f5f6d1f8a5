#include "host/commission/balls/scale_check.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/commission/core/least_squares.hpp"

namespace strobe::commission {
namespace {

constexpr int kMinSizes = 8;
/// Of a diameter, as a share: what texture and light leave of images that state less.
constexpr double kMinShareSd = 2e-4;

struct Size {
  double across, upwards;  ///< from the photograph's middle, over its width and height
  double log_ratio;
  double weight;
};

std::vector<Size> sizes_of(const reduction::Frame& frame, double diameter_px, double width_px,
                           double height_px) {
  std::vector<Size> sizes;
  for (const reduction::BallImage& image : frame.images) {
    const bool in_air = image.leg == strobe::Leg::incoming || image.leg == strobe::Leg::rebound;
    if (!in_air || !(image.diameter_px > 0.0)) continue;
    const double share_sd =
        image.diameter_sd_px.value_or(frame.diameter_sd_px.value_or(0.5)) / image.diameter_px;
    sizes.push_back({image.centre_px.x / width_px - 0.5, image.centre_px.y / height_px - 0.5,
                     std::log(image.diameter_px / diameter_px),
                     1.0 / (share_sd * share_sd + kMinShareSd * kMinShareSd)});
  }
  return sizes;
}

struct Plane {
  Eigen::Vector3d terms = Eigen::Vector3d::Zero();  ///< middle, across, upwards
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// Weighted least squares; residuals that are larger than stated make the sds larger.
Plane fit_plane(std::span<const Size> sizes) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Size& s : sizes) {
    const Eigen::Vector3d row(1.0, s.across, s.upwards);
    information += s.weight * row * row.transpose();
    sum += s.weight * s.log_ratio * row;
  }
  Plane plane;
  plane.terms = solve_normal(information, sum);
  double chi_squared = 0.0;
  for (const Size& s : sizes) {
    const double off = s.log_ratio - plane.terms.dot(Eigen::Vector3d(1.0, s.across, s.upwards));
    chi_squared += s.weight * off * off;
  }
  const double freedom = static_cast<double>(sizes.size()) - 3.0;
  plane.covariance = std::max(1.0, chi_squared / freedom) * information.inverse();
  return plane;
}

double mean_of(std::span<const Size> sizes, const Plane& plane) {
  double sum = 0.0, weights = 0.0;
  for (const Size& s : sizes) {
    sum += s.weight * (s.log_ratio - plane.terms[1] * s.across - plane.terms[2] * s.upwards);
    weights += s.weight;
  }
  return sum / weights;
}

}  // namespace

Result<ScaleCheck> check_scale(std::span<const reduction::Frame> frames, double px_per_m,
                               double ball_diameter_m, double width_px, double height_px) {
  std::vector<std::vector<Size>> by_shot;
  std::vector<Size> all;
  for (const reduction::Frame& frame : frames) {
    auto sizes = sizes_of(frame, px_per_m * ball_diameter_m, width_px, height_px);
    if (sizes.empty()) continue;
    all.insert(all.end(), sizes.begin(), sizes.end());
    by_shot.push_back(std::move(sizes));
  }
  if (static_cast<int>(all.size()) < kMinSizes) return fail("fewer than 8 images of balls in the air");
  const Plane plane = fit_plane(all);
  ScaleCheck check;
  check.images = static_cast<int>(all.size());
  check.shots = static_cast<int>(by_shot.size());
  check.ratio = std::exp(plane.terms[0]);
  check.across = plane.terms[1];
  check.upwards = plane.terms[2];
  check.across_sd = std::sqrt(plane.covariance(1, 1));
  check.upwards_sd = std::sqrt(plane.covariance(2, 2));
  double variance = plane.covariance(0, 0);
  if (by_shot.size() > 1) {
    // Balls that fly nearer to the lens than others are larger in all of their images.
    double spread = 0.0;
    for (const auto& sizes : by_shot) spread += std::pow(mean_of(sizes, plane) - plane.terms[0], 2.0);
    const auto shots = static_cast<double>(by_shot.size());
    variance = std::max(variance, spread / (shots - 1.0) / shots);
  }
  check.ratio_sd = check.ratio * std::sqrt(variance);
  return check;
}

}  // namespace strobe::commission
