#include "tests/host/digitize/dotted_ball.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>

namespace strobe::testing {

namespace {

/// Where a ray through the picture meets the unit ball, seen from a lens on the z axis.
std::optional<Eigen::Vector3d> hit(double u, double v, double distance) {
  // At the limb, u = 1, the ray's slope is 1/sqrt(d^2 - 1).
  const double limb = 1.0 / std::sqrt(distance * distance - 1.0);
  const Eigen::Vector3d along = Eigen::Vector3d(u * limb, v * limb, -1.0).normalized();
  const Eigen::Vector3d from(0.0, 0.0, distance);
  const double b = from.dot(along), c = distance * distance - 1.0, root = b * b - c;
  if (root < 0.0) return std::nullopt;
  return Eigen::Vector3d(from + (-b - std::sqrt(root)) * along);
}

double light_at(const DottedBall& ball, const std::vector<Eigen::Vector3d>& dots, double u, double v) {
  constexpr double kDark = 0.06;
  // Rounding of a far lens: its rays are parallel.
  const auto at = ball.distance_radii > 1e4
                      ? (u * u + v * v < 1.0 ? std::optional(Eigen::Vector3d(u, v, std::sqrt(1.0 - u * u - v * v))) : std::nullopt)
                      : hit(u, v, ball.distance_radii);
  if (!at) return kDark;
  const double lit = 0.2 + 0.55 * std::max(0.0, at->dot(ball.lamp.normalized()));
  const double least = std::cos(ball.dot_radius_rad);
  const bool dark = std::ranges::any_of(dots, [&](const Eigen::Vector3d& dot) { return dot.dot(*at) > least; });
  return dark ? ball.dot_light * lit : lit;
}

}  // namespace

digitize::Photograph photograph_of(const DottedBall& ball) {
  constexpr int kFine = 5;  // rays to a pixel's side
  const int side = static_cast<int>(std::ceil(1.3 * ball.diameter_px));
  std::vector<Eigen::Vector3d> dots;
  for (const Eigen::Vector3d& dot : ball.dots) dots.push_back(ball.attitude * dot);
  cv::Mat fine(side * kFine, side * kFine, CV_32F);
  const double radius = 0.5 * ball.diameter_px, middle = 0.5 * (side - 1);
  for (int j = 0; j < fine.rows; ++j) {
    for (int i = 0; i < fine.cols; ++i) {
      const double column = (i + 0.5) / kFine - 0.5, row = (j + 0.5) / kFine - 0.5;
      fine.at<float>(j, i) = static_cast<float>(light_at(ball, dots, (column - middle - ball.off_px.x()) / radius,
                                                         (middle - ball.off_px.y() - row) / radius));
    }
  }
  if (ball.smear_px > 0.0) cv::blur(fine, fine, {2 * static_cast<int>(0.5 * ball.smear_px * kFine) + 1, 1});
  cv::GaussianBlur(fine, fine, {}, ball.blur_px * kFine);
  digitize::Photograph photograph;
  photograph.name = "dotted ball";
  cv::resize(fine, photograph.intensity, {side, side}, 0, 0, cv::INTER_AREA);
  std::mt19937_64 random(ball.seed);
  std::normal_distribution<double> normal;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      float& pixel = photograph.intensity.at<float>(j, i);
      pixel = static_cast<float>(std::clamp(std::round(255.0 * (pixel + ball.noise * normal(random))) / 255.0, 0.0, 1.0));
    }
  return photograph;
}

Eigen::Matrix3d attitude_from(double a, double b, double c) {
  const double s = std::sqrt(1.0 - a), t = std::sqrt(a), p = 2.0 * std::numbers::pi * b, q = 2.0 * std::numbers::pi * c;
  return Eigen::Quaterniond(t * std::cos(q), s * std::sin(p), s * std::cos(p), t * std::sin(q)).toRotationMatrix();
}

std::vector<Eigen::Vector3d> drawn_pattern(int dots, double apart_rad, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> pattern;
  while (std::ssize(pattern) < dots) {
    const Eigen::Vector3d dot = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    if (std::ranges::all_of(pattern, [&](const auto& other) { return dot.dot(other) < std::cos(apart_rad); })) pattern.push_back(dot);
  }
  return pattern;
}

}  // namespace strobe::testing
