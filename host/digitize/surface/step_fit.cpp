#include "host/digitize/surface/step_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr int kMaxSteps = 20;
constexpr double kConverged_px = 1e-3;
constexpr double kMaxAway_px = 2.0;
constexpr int kMinSamples = 5;

/// A cumulative distribution of sd 1 and its integral.
struct Distribution {
  double value = 0.0, integral = 0.0;
};

Distribution distribution(Blur blur, double z) {
  if (blur == Blur::normal) {
    const double value = 0.5 * std::erfc(-z / std::numbers::sqrt2);
    return {value, z * value + std::exp(-0.5 * z * z) / std::sqrt(2.0 * std::numbers::pi)};
  }
  constexpr double kScale = std::numbers::pi / std::numbers::sqrt3;
  const double falling = std::exp(-kScale * std::abs(z));
  return {z > 0.0 ? 1.0 / (1.0 + falling) : falling / (1.0 + falling),
          std::max(z, 0.0) + std::log1p(falling) / kScale};
}

/// Background, step and place.
struct Step {
  double background = 0.0, height = 0.0, at = 0.0;
};

struct Normal {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double squares = 0.0;
};

class StepFitter {
 public:
  StepFitter(std::span<const double> intensity, double saturation, double start, const StepShape& shape)
      : intensity_(intensity), saturation_(saturation), shape_(shape) {
    const double reach = 3.0 * shape.sd_px + kMaxAway_px;
    from_ = std::max(0, static_cast<int>(std::ceil(start - reach)));
    to_ = std::min(static_cast<int>(intensity.size()) - 1, static_cast<int>(std::floor(start + reach)));
  }
  int samples() const { return to_ - from_ + 1; }
  bool saturated() const {
    return std::any_of(intensity_.begin() + from_, intensity_.begin() + to_ + 1,
                       [&](double light) { return light >= saturation_; });
  }
  void ignore_saturated(bool ignore) { ignore_saturated_ = ignore; }

  Step first_guess(double start) const {
    double least = sample(from_), most = least;
    for (int k = from_; k <= to_; ++k) {
      least = std::min(least, sample(k));
      most = std::max(most, sample(k));
    }
    return {least, most - least, start};
  }

  Normal normal_equations(const Step& step) const {
    Normal normal;
    Distribution far = distribution(shape_.blur, (from_ - 0.5 - step.at) / shape_.sd_px);
    for (int k = from_; k <= to_; ++k) {
      const Distribution near = far;
      far = distribution(shape_.blur, (k + 0.5 - step.at) / shape_.sd_px);
      // Over the area of a pixel.
      const double value = shape_.sd_px * (far.integral - near.integral);
      const double left = std::min(sample(k), saturation_) - step.background - step.height * value;
      if (sample(k) >= saturation_ && (ignore_saturated_ || left <= 0.0)) continue;
      const Eigen::Vector3d by(1.0, value, -step.height * (far.value - near.value));
      normal.matrix += by * by.transpose();
      normal.right += by * left;
      normal.squares += left * left;
    }
    return normal;
  }

 private:
  double sample(int k) const { return intensity_[static_cast<std::size_t>(k)]; }

  std::span<const double> intensity_;
  double saturation_;
  StepShape shape_;
  bool ignore_saturated_ = false;
  int from_ = 0, to_ = -1;
};

/// By no more than a px at a time.
bool improve(const StepFitter& fitter, Step& step, Normal& normal, double& damping) {
  Eigen::Matrix3d damped = normal.matrix;
  damped.diagonal() *= 1.0 + damping;
  const Eigen::Vector3d by = damped.ldlt().solve(normal.right);
  if (!by.allFinite()) return false;
  const Step next{step.background + by[0], step.height + by[1], step.at + std::clamp(by[2], -1.0, 1.0)};
  const Normal there = fitter.normal_equations(next);
  if (there.squares > normal.squares) {
    damping = std::max(10.0 * damping, 1e-3);
    return true;
  }
  const bool more = std::abs(next.at - step.at) > kConverged_px;
  damping *= 0.1;
  step = next;
  normal = there;
  return more;
}

std::optional<StepFit> fit_from(const StepFitter& fitter, Step step, double start) {
  Normal normal = fitter.normal_equations(step);
  double damping = 0.0;
  for (int k = 0; k < kMaxSteps && improve(fitter, step, normal, damping); ++k) {
  }
  if (!(step.height > 0.0) || !(std::abs(step.at - start) <= kMaxAway_px)) return std::nullopt;
  const Eigen::Vector3d place = normal.matrix.ldlt().solve(Eigen::Vector3d::UnitZ());
  if (!(place[2] > 0.0) || !std::isfinite(place[2])) return std::nullopt;
  return StepFit{step.at, step.background, step.height, normal.squares, place[2]};
}

}  // namespace

std::optional<StepFit> fit_step(std::span<const double> intensity, double saturation, double start,
                                const StepShape& shape) {
  StepFitter fitter(intensity, saturation, start, shape);
  if (fitter.samples() < kMinSamples) return std::nullopt;
  Step first = fitter.first_guess(start);
  if (!fitter.saturated()) return fit_from(fitter, first, start);
  // A step that ends at saturation fits what is saturated without fitting the rest, and is hard to leave from below.
  first.height *= 2.0;
  fitter.ignore_saturated(true);
  const auto fit = fit_from(fitter, first, start);
  fitter.ignore_saturated(false);
  if (!fit) return std::nullopt;
  return fit_from(fitter, {fit->background, fit->step, fit->at}, start);
}

}  // namespace strobe::digitize
