#include "host/commission/scale_check.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "host/commission/statistics.hpp"

namespace strobe::commission {
namespace {

constexpr int kMinSizes = 8;
/// Of a diameter, as a share: what texture and light leave of images that state less.
constexpr double kMinShareSd = 2e-4;

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

double mean_of(std::span<const Size> sizes, const SizePlane& plane) {
  double sum = 0.0, weights = 0.0;
  for (const Size& s : sizes) {
    sum += s.weight * (s.log_ratio - plane.terms[1] * s.across - plane.terms[2] * s.upwards);
    weights += s.weight;
  }
  return sum / weights;
}

}  // namespace

SizePlane fit_plane(std::span<const Size> sizes, double least_square) {
  const auto row = [](const Size& s) { return Eigen::Vector3d(1.0, s.across, s.upwards); };
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Size& s : sizes) {
    information += s.weight * row(s) * row(s).transpose();
    sum += s.weight * s.log_ratio * row(s);
  }
  const Eigen::Vector3d terms = solve_normal(information, sum);
  double chi_squared = 0.0;
  for (const Size& s : sizes) chi_squared += s.weight * std::pow(s.log_ratio - terms.dot(row(s)), 2);
  const double freedom = std::max(1.0, static_cast<double>(sizes.size()) - 3.0);
  return {terms, std::max(least_square, chi_squared / freedom) * information.inverse()};
}

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
  const SizePlane plane = fit_plane(all, 1.0);
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

StepResult judge_scale(const ScaleCheck& check, double diameter_share_sd, double scale_share_sd) {
  const double off = check.ratio - 1.0;
  // The digitizer's own error of a diameter is below 0.02 % of it (host/digitize/README.md).
  constexpr double kDigitizer = 2e-4, kMatters = 0.004;
  const double sd =
      std::hypot(std::hypot(check.ratio_sd, diameter_share_sd), std::hypot(scale_share_sd, kDigitizer));
  StepResult result =
      passed(100.0 * off, 100.0 * sd, "%", fmt::format("0 within {:.2f} %", 100.0 * kMatters));
  result.words =
      fmt::format("balls look {:+.2f} ± {:.2f} % larger than scale and diameter say; {} images of {} balls",
                  100.0 * off, 100.0 * sd, check.images, check.shots);
  result.figures = {{"size_off_percent", 100.0 * off, 100.0 * sd, 0.0, check.images}};
  hold(result, interval(off, sd), within(kMatters), "scale_off",
       "measure the ball's diameter again, and calibrate with the board in the plane where balls fly; if "
       "step gravity has passed, the ball's diameter or the board's place is wrong",
       diameter_share_sd > std::max(check.ratio_sd, scale_share_sd)
           ? "measure the ball's diameter in ten places with callipers, and enter diameter_sd_m in [ball]"
           : kMoreShots);
  return result;
}

StepResult judge_squareness(const ScaleCheck& check) {
  const bool sideways = std::abs(check.across) >= std::abs(check.upwards);
  const double slope = sideways ? check.across : check.upwards;
  const double sd = sideways ? check.across_sd : check.upwards_sd;
  StepResult result =
      passed(100.0 * slope, 100.0 * sd, "%",
             fmt::format("0 within {:.2f} % over the photograph's width and height", 100.0 * kMaxSlope));
  result.words = fmt::format(
      "balls grow by {:+.2f} ± {:.2f} % from left to right, {:+.2f} ± {:.2f} % upwards", 100.0 * check.across,
      100.0 * check.across_sd, 100.0 * check.upwards, 100.0 * check.upwards_sd);
  result.figures = {{"across_percent", 100.0 * check.across, 100.0 * check.across_sd, 0.0, check.images},
                    {"upwards_percent", 100.0 * check.upwards, 100.0 * check.upwards_sd, 0.0, check.images}};
  for (const Interval& found :
       {interval(check.across, check.across_sd), interval(check.upwards, check.upwards_sd)})
    hold(result, found, within(kMaxSlope), "camera_tilted",
         "the camera has moved since its calibration, or balls fly towards the lens or away: calibrate again "
         "with the board in the plane where balls fly");
  return result;
}

}  // namespace strobe::commission
