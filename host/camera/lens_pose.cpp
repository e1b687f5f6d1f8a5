#include "host/camera/lens_pose.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

namespace strobe::camera {
namespace {

constexpr std::size_t kHomography = 8;  ///< its parameters
constexpr double kMaxShare = 0.25;

/// How far the first two columns are from right angles and from equal lengths, as shares.
cv::Vec2d deviations(std::span<const double> h, double focal) {
  const cv::Vec3d a(h[0] / focal, h[3] / focal, h[6]), b(h[1] / focal, h[4] / focal, h[7]);
  const double size = 0.5 * (a.dot(a) + b.dot(b));
  return {a.dot(b) / size, 0.5 * (a.dot(a) - b.dot(b)) / size};
}

/// The lens' centre is taken to be the photograph's, from which lenses are some per mille of the diagonal
/// off: enough to make a slight tilt tell nothing of the focal length.
cv::Matx22d centre_spread(const std::vector<double>& h, double focal) {
  constexpr double kCentreSd = 0.004;
  cv::Matx22d spread = cv::Matx22d::zeros();
  for (const std::size_t row : {std::size_t{0}, std::size_t{3}}) {
    std::vector<double> moved = h;
    for (std::size_t i = 0; i < 2; ++i) moved[row + i] += kCentreSd * h[6 + i];
    const cv::Vec2d change = deviations(moved, focal) - deviations(h, focal);
    spread += change * change.t();
  }
  return spread;
}

double chi_square(const BoardFit& fit, std::size_t view, double focal) {
  std::vector<double> h(fit.parameters.begin() + static_cast<std::ptrdiff_t>(view * kHomography),
                        fit.parameters.begin() + static_cast<std::ptrdiff_t>((view + 1) * kHomography));
  const cv::Vec2d g = deviations(h, focal);
  cv::Matx<double, 2, 8> slopes;
  cv::Matx<double, 8, 8> covariance;
  for (std::size_t i = 0; i < kHomography; ++i) {
    const double step = 1e-6 * std::max(std::abs(h[i]), 1e-3), kept = h[i];
    h[i] = kept + step;
    const cv::Vec2d up = deviations(h, focal);
    h[i] = kept - step;
    const cv::Vec2d slope = (up - deviations(h, focal)) * (0.5 / step);
    h[i] = kept;
    slopes(0, static_cast<int>(i)) = slope[0];
    slopes(1, static_cast<int>(i)) = slope[1];
    for (std::size_t j = 0; j < kHomography; ++j) {
      covariance(static_cast<int>(i), static_cast<int>(j)) = fit.covariance.at<double>(
          static_cast<int>(view * kHomography + i), static_cast<int>(view * kHomography + j));
    }
  }
  const cv::Matx22d spread =
      slopes * covariance * slopes.t() + centre_spread(h, focal) + cv::Matx22d::eye() * 1e-24;
  return (g.t() * spread.inv() * g)(0);
}

LensPose pose_of(const BoardFit& fit, double focal) {
  const std::span<const double> h(fit.parameters.data(), kHomography);
  cv::Vec3d a(h[0] / focal, h[3] / focal, h[6]), b(h[1] / focal, h[4] / focal, h[7]);
  const cv::Vec3d t(h[2] / focal, h[5] / focal, 1.0);
  const double length = std::sqrt(0.5 * (a.dot(a) + b.dot(b)));
  a = a * (1.0 / length);
  b = b * (1.0 / length);
  const cv::Vec3d normal = cv::normalize(a.cross(b));
  const cv::Vec3d to_board = t * (1.0 / length);
  LensPose pose;
  pose.focal = focal;
  pose.foot_m = {-a.dot(to_board), -b.dot(to_board)};
  pose.distance_m = std::abs(normal.dot(to_board));
  pose.tilt_rad = std::acos(std::min(1.0, std::abs(normal[2])));
  return pose;
}

/// Where a function of one variable that was least at `least` has risen by one, in a direction.
double risen_by_one(const std::function<double(double)>& f, double least, double direction, double limit) {
  const double wanted = f(least) + 1.0;
  double inside = 0.0, outside = 1e-5;
  while (f(least + direction * outside) < wanted) {
    inside = outside;
    outside *= 1.5;
    if (outside > limit) return limit;
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (inside + outside);
    (f(least + direction * middle) < wanted ? inside : outside) = middle;
  }
  return outside;
}

double least_of(const std::function<double(double)>& f, double from, double to) {
  constexpr int kSteps = 300;
  const double step = (to - from) / kSteps;
  double best = from;
  double value = f(from);
  for (int i = 1; i <= kSteps; ++i) {
    const double at = f(from + i * step);
    if (at < value) {
      value = at;
      best = from + i * step;
    }
  }
  double low = best - step, high = best + step;
  for (int i = 0; i < 80; ++i) {
    const double third = (high - low) / 3.0;
    f(low + third) < f(high - third) ? high -= third : low += third;
  }
  return 0.5 * (low + high);
}

}  // namespace

std::optional<LensPose> locate_lens(const BoardFit& fit, std::optional<double> distance_m,
                                    double distance_sd_m) {
  const auto misfit = [&](double log_focal) {
    const double focal = std::exp(log_focal);
    double sum = 0.0;
    for (std::size_t v = 0; v < fit.homographies.size(); ++v) sum += chi_square(fit, v, focal);
    if (!distance_m) return sum;
    const double off = (pose_of(fit, focal).distance_m - *distance_m) / distance_sd_m;
    return sum + off * off;
  };
  // From a fisheye to a telescope, in diagonals of the photograph.
  const double from = std::log(0.15), to = std::log(150.0);
  const double best = least_of(misfit, from, to);
  const double above = risen_by_one(misfit, best, 1.0, 1.0), below = risen_by_one(misfit, best, -1.0, 1.0);
  LensPose pose = pose_of(fit, std::exp(best));
  const double high = pose_of(fit, std::exp(best + above)).distance_m;
  const double low = pose_of(fit, std::exp(best - below)).distance_m;
  pose.distance_sd_m = 0.5 * std::abs(high - low);
  if (std::max(above, below) >= kMaxShare || pose.distance_sd_m > kMaxShare * pose.distance_m) {
    return std::nullopt;
  }
  return pose;
}

}  // namespace strobe::camera
