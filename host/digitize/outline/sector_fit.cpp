#include "host/digitize/outline/sector_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>
#include <optional>

namespace strobe::digitize {

namespace {

constexpr int kMaxNeighbours = 3;
constexpr int kOwn = 5;  // linear terms without neighbours
constexpr int kMaxLinear = kOwn + 2 * kMaxNeighbours;
constexpr int kExtra = 5;  // derivatives of step and root by depth and sigma, intensity
constexpr int kMaxTerms = kMaxLinear + kExtra;
// The linear terms are, in this order: an even background, step and root of each neighbour, and of this
// outline slope, limb, deviation from it, and inner slope. Those that have a prior come last (noise_of()).
constexpr int kPriorTerms = 4;
constexpr std::size_t kSlope = 0, kLimb = 1, kDeviation = 2, kInnerSlope = 3;  // from first_prior_term()
constexpr int kLanes = 4;
constexpr int kMaxDepths = SectorSamples::kMaxDepths;
constexpr int kMinDegreesOfFreedom = 4;
constexpr double kCoarseSd = 2.0;
// Bilinear interpolation removes a third of white noise's variance, but not its slow part, which makes the
// fit's error (a cubic B-spline's values at 0, ±1: 2/3, 1/6).
constexpr double kInterpolation = 1.5;

/// The sector's intensity and the model's terms, a row each, by depth.
struct SectorTerms {
  alignas(16) std::array<std::array<float, kMaxDepths>, kMaxTerms> row;
  int linear = kOwn;
  int depths = 0;

  std::size_t first_prior_term() const { return static_cast<std::size_t>(linear - kPriorTerms); }
  int count() const { return linear + kExtra; }
  void pad() {
    while (depths % kLanes != 0) {
      for (int i = 0; i < count(); ++i)
        row[static_cast<std::size_t>(i)][static_cast<std::size_t>(depths)] = 0.0F;
      ++depths;
    }
  }
};

struct NormalEquations {
  std::array<std::array<double, kMaxTerms>, kMaxTerms> m;
  int linear = kOwn;

  std::size_t first_prior_term() const { return static_cast<std::size_t>(linear - kPriorTerms); }
  std::size_t light() const {
    return static_cast<std::size_t>(linear + kExtra - 1);
  }  ///< the intensity's row
};

NormalEquations products(const SectorTerms& terms) {
  NormalEquations normal;
  normal.linear = terms.linear;
  for (std::size_t i = 0; i < static_cast<std::size_t>(terms.count()); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      cv::v_float32x4 sum = cv::v_setzero_f32();
      for (std::size_t k = 0; k < static_cast<std::size_t>(terms.depths); k += kLanes)
        sum = cv::v_muladd(cv::v_load_aligned(&terms.row[i][k]), cv::v_load_aligned(&terms.row[j][k]), sum);
      normal.m[i][j] = cv::v_reduce_sum(sum);
    }
  }
  return normal;
}

using Neighbours = std::array<const OutlineShape*, kMaxNeighbours>;

/// The nearest of the neighbours whose limb crosses the sector. Returns their number.
int choose_neighbours(std::span<const OutlineShape> neighbours, cv::Point2d middle, double window,
                      double sigma, Neighbours& chosen) {
  int count = 0;
  std::array<double, kMaxNeighbours> distance{};
  for (const OutlineShape& other : neighbours) {
    const double depth = other.depth(middle);
    if (depth < -window - 4.0 * sigma || depth > 2.0 * window) continue;
    int at = count < kMaxNeighbours ? count++ : kMaxNeighbours;
    for (; at > 0 && distance[static_cast<std::size_t>(at - 1)] > std::abs(depth); --at) {
      if (at == kMaxNeighbours) continue;
      distance[static_cast<std::size_t>(at)] = distance[static_cast<std::size_t>(at - 1)];
      chosen[static_cast<std::size_t>(at)] = chosen[static_cast<std::size_t>(at - 1)];
    }
    if (at == kMaxNeighbours) continue;
    distance[static_cast<std::size_t>(at)] = std::abs(depth);
    chosen[static_cast<std::size_t>(at)] = &other;
  }
  return count;
}

void add_neighbour(SectorTerms& terms, std::size_t first, const SectorSamples& samples, int index,
                   double shift, const OutlineShape& other, const ProfileTable& profiles) {
  const SectorSamples::Profile profile = samples.profile(index);
  const cv::Point2d out = samples.direction(index);
  const double slope = std::tan(samples.half_width_rad());
  for (std::size_t k = 0; k < profile.intensity.size(); ++k) {
    const double depth = profile.depth_px + static_cast<double>(k) * samples.depth_step_px();
    const cv::Point2d at = samples.middle(index) - depth * out;
    const cv::Point2d side = slope * samples.radius_px(index, depth) * cv::Point2d(-out.y, out.x);
    const auto [step, root] = profiles.mean(other.depth(at - side) - shift, other.depth(at + side) - shift);
    terms.row[first][k] = step;
    terms.row[first + 1][k] = root;
  }
}

// What is known of a limb before its sector is seen. Of its rise over a window, the part that grows as the
// root is anything from none (light from all around, fuzz) to all (a matt sphere lit from the camera):
// uniform, with the mean 1/2 and the variance 1/12. A window is at most .3 of a radius deep, and light on a
// sphere, this one or one behind it, changes by as much as it is over a radius: slopes of ball and background
// are within .3 of it.
constexpr float kRootShare = 0.5F;
constexpr double kRootShareVariance = 1.0 / 12.0, kSlopeVariance = 0.3 * 0.3;

SectorTerms terms_of(const SectorSamples& samples, int index, const OutlineShape& shape,
                     std::span<const OutlineShape* const> neighbours, const ProfileTable& profiles,
                     double sigma) {
  SectorTerms terms;
  terms.linear = kOwn + 2 * static_cast<int>(neighbours.size());
  const SectorSamples::Profile profile = samples.profile(index);
  const double shift = inward_shift(shape.radius, sigma);
  const double moved = profile.depth_px + shape.depth(samples.middle(index)) - shift;
  const double unit = 1.0 / samples.window_px();
  const auto extra = static_cast<std::size_t>(terms.linear);
  const std::size_t own = terms.first_prior_term();
  for (std::size_t k = 0; k < profile.intensity.size(); ++k) {
    const double depth = moved + static_cast<double>(k) * samples.depth_step_px();
    const ProfileTable::Entry entry = profiles.at(depth);
    const auto inwards = static_cast<float>(depth * unit);
    terms.row[0][k] = 1.0F;
    terms.row[own + kSlope][k] = inwards;
    terms.row[own + kLimb][k] = (1.0F - kRootShare) * entry.step + kRootShare * entry.root;
    terms.row[own + kDeviation][k] = entry.root - entry.step;
    terms.row[own + kInnerSlope][k] = entry.step * inwards;
    terms.row[extra][k] = entry.step_by_depth;
    terms.row[extra + 1][k] = entry.root_by_depth;
    terms.row[extra + 2][k] = entry.step_by_sigma;
    terms.row[extra + 3][k] = entry.root_by_sigma;
    terms.row[extra + 4][k] = profile.intensity[k];
  }
  std::size_t next = 1;
  for (const OutlineShape* other : neighbours) {
    add_neighbour(terms, next, samples, index, shift, *other, profiles);
    next += 2;
  }
  terms.depths = static_cast<int>(profile.intensity.size());
  terms.pad();
  return terms;
}

/// Rise of intensity over the limb, with nothing but an even background fitted beside it.
double rough_rise(const NormalEquations& normal) {
  const std::size_t limb = normal.first_prior_term() + kLimb;
  const double mean = normal.m[limb][0] / normal.m[0][0];
  const double own = normal.m[limb][limb] - mean * normal.m[limb][0];
  return own > 0.0 ? (normal.m[normal.light()][limb] - mean * normal.m[normal.light()][0]) / own : 0.0;
}

/// The deviation from the limb, like the slopes, is expected to be small against its rise: by as much as
/// noise, texture among it, hides. Without noise nothing is assumed; in bad light, where the terms are nearly
/// collinear, the limb is of the common shape.
void add_limb_prior(NormalEquations& normal, double rise, double noise2) {
  const double relative = noise2 / (rise * rise + noise2);
  const std::size_t own = normal.first_prior_term();
  normal.m[own + kSlope][own + kSlope] += relative / kSlopeVariance;
  normal.m[own + kDeviation][own + kDeviation] += relative / kRootShareVariance;
  normal.m[own + kInnerSlope][own + kInnerSlope] += relative / kSlopeVariance;
}

/// Of a neighbour's limb, which otherwise explains one parallel to it, step and root are each anything from
/// none to all of its rise, or of this outline's where that is not known yet: a mean square of a third.
void add_neighbours_prior(NormalEquations& normal, std::span<const OutlineShape* const> neighbours,
                          double rise, double noise2) {
  for (std::size_t k = 0; k < neighbours.size(); ++k) {
    const double of_limb = neighbours[k]->rise > 0.0 ? neighbours[k]->rise : rise;
    for (const std::size_t j : {2 * k + 1, 2 * k + 2})
      normal.m[j][j] += 3.0 * noise2 / (of_limb * of_limb + noise2);
  }
}

/// Keeps nearly collinear terms apart.
void add_ridge(NormalEquations& normal) {
  for (std::size_t j = 0; j < static_cast<std::size_t>(normal.linear); ++j) normal.m[j][j] *= 1.0 + 1e-6;
}

/// Projects the linear terms from `first` to `last` out of all after them by a Cholesky factorization, row by
/// row: afterwards m[i][j] of the others holds the products of their residuals, and m[light][j] of such a
/// term j holds (L⁻¹ b)_j, b being its products with the intensity.
void project(NormalEquations& normal, std::size_t first, std::size_t last) {
  const std::size_t terms = normal.light() + 1;
  for (std::size_t i = first; i < terms; ++i) {
    for (std::size_t j = first; j <= i; ++j) {
      double sum = normal.m[i][j];
      for (std::size_t k = first; k < std::min(j, last); ++k) sum -= normal.m[i][k] * normal.m[j][k];
      if (j >= last) {
        normal.m[i][j] = sum;
      } else if (i == j) {
        normal.m[i][i] = std::sqrt(std::max(sum, 1e-9));
      } else {
        normal.m[i][j] = sum / normal.m[j][j];
      }
    }
  }
}

/// Variance of the intensity around the freest of the models, once all terms without a prior are projected
/// out.
double noise_of(const NormalEquations& normal, int degrees_of_freedom) {
  std::array<std::array<double, kPriorTerms>, kPriorTerms + 1> factor;
  const std::size_t own = normal.first_prior_term();
  double left = normal.m[normal.light()][normal.light()];
  for (std::size_t i = 0; i <= kPriorTerms; ++i) {
    const auto& products = normal.m[i < kPriorTerms ? own + i : normal.light()];
    for (std::size_t j = 0; j < std::min<std::size_t>(i + 1, kPriorTerms); ++j) {
      double sum = products[own + j];
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i][k] * factor[j][k];
      factor[i][j] = i == j ? std::sqrt(std::max(sum, 1e-9)) : sum / factor[j][j];
      if (i == kPriorTerms) left -= factor[i][j] * factor[i][j];
    }
  }
  return kInterpolation * std::max(left, 0.0) / degrees_of_freedom + 1e-14;
}

/// The amplitudes of the terms that have a prior, by back substitution.
std::array<double, kPriorTerms> amplitudes(const NormalEquations& normal) {
  std::array<double, kPriorTerms> x{};
  const std::size_t own = normal.first_prior_term();
  for (std::size_t i = kPriorTerms; i-- > 0;) {
    double sum = normal.m[normal.light()][own + i];
    for (std::size_t k = i + 1; k < kPriorTerms; ++k) sum -= normal.m[own + k][own + i] * x[k];
    x[i] = sum / normal.m[own + i][own + i];
  }
  return x;
}

/// Products of a sector's residuals after projection, for the fitted amplitudes of step and root.
class Residuals {
 public:
  Residuals(const NormalEquations& normal, double noise2)
      : normal_(normal), noise2_(noise2), first_(static_cast<std::size_t>(normal.linear)) {
    const auto x = amplitudes(normal);
    step_ = x[kLimb] * (1.0 - kRootShare) - x[kDeviation];
    root_ = x[kLimb] * kRootShare + x[kDeviation];
    depth_depth_ = step_ * step_ * of(0, 0) + 2 * step_ * root_ * of(0, 1) + root_ * root_ * of(1, 1);
    if (depth_depth_ > 0.0) offset_ = (step_ * of(0, 4) + root_ * of(1, 4)) / depth_depth_;
  }

  double step() const { return step_; }
  double root() const { return root_; }

  /// How far inside of the outline the light may begin where no lamp reaches the limb: there the fitted step
  /// is negative, and the profile rises to the background's level at (step/root)² of the window. Returns
  /// nullopt if the limb is in shadow. The amplitude is taken at the given outline, so that the test favours
  /// no offset; while the outline is still coarse its own offset is allowed for.
  std::optional<double> shadow_depth(double window_px, bool coarse) const {
    const StepSd sd = step_sd();
    if (coarse) {
      if (step_ - sd.by_depth * offset_ < -kCoarseSd * sd.moving) return std::nullopt;
      return 0.0;
    }
    if (step_ < -sd.fixed) return std::nullopt;
    if (step_ > sd.fixed) return 0.0;
    if (root_ <= 0.0) return std::nullopt;
    return window_px * std::pow((sd.fixed - step_) / root_, 2);
  }

  SectorEdge edge() const {
    SectorEdge edge;
    if (!(depth_depth_ > 0.0)) return edge;
    const double sigma_sigma =
        step_ * step_ * of(2, 2) + 2 * step_ * root_ * of(2, 3) + root_ * root_ * of(3, 3);
    const double depth_sigma =
        step_ * step_ * of(0, 2) + step_ * root_ * (of(0, 3) + of(1, 2)) + root_ * root_ * of(1, 3);
    const double sigma_light = step_ * of(2, 4) + root_ * of(3, 4);
    edge.usable = true;
    edge.offset_px = offset_;
    edge.sd_px = std::sqrt(noise2_ / depth_depth_);
    const double sigma_left = sigma_sigma - depth_sigma * depth_sigma / depth_depth_;
    edge.sigma_weight = std::max(0.0, sigma_left) / noise2_;
    edge.offset_by_sigma = -depth_sigma / depth_depth_;
    edge.sigma_change = (sigma_light - depth_sigma * edge.offset_px) / noise2_;
    return edge;
  }

 private:
  double of(std::size_t i, std::size_t j) const {
    return normal_.m[first_ + std::max(i, j)][first_ + std::min(i, j)];
  }

  struct StepSd {
    double fixed = 0.0;     ///< of the step's amplitude, the outline given
    double moving = 0.0;    ///< the outline being fitted too
    double by_depth = 0.0;  ///< change of the amplitude as the outline moves out
  };
  StepSd step_sd() const {
    std::array<double, kPriorTerms> unit{};
    const std::size_t own = normal_.first_prior_term();
    double variance = 0.0, shared = 0.0;
    for (std::size_t i = kLimb; i < kPriorTerms; ++i) {
      double sum = i == kLimb ? 1.0 - kRootShare : i == kDeviation ? -1.0 : 0.0;
      for (std::size_t k = kLimb; k < i; ++k) sum -= normal_.m[own + i][own + k] * unit[k];
      unit[i] = sum / normal_.m[own + i][own + i];
      variance += unit[i] * unit[i];
      shared += unit[i] * (step_ * normal_.m[first_][own + i] + root_ * normal_.m[first_ + 1][own + i]);
    }
    return {std::sqrt(noise2_ * variance), std::sqrt(noise2_ * (variance + shared * shared / depth_depth_)),
            shared};
  }

  const NormalEquations& normal_;
  double noise2_;
  std::size_t first_;
  double step_ = 0.0, root_ = 0.0, depth_depth_ = 0.0, offset_ = 0.0;
};

}  // namespace

ProfileTable sector_profiles(const SectorSamples& samples, double radius_px, double sigma_px) {
  const double window = samples.window_px();
  return {sigma_px, radius_px, window, -2.0 * window - 4.0 * sigma_px, 3.5 * window + 4.0 * sigma_px};
}

SectorEdge fit_sector(const SectorSamples& samples, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, const ProfileTable& profiles, double sigma_px,
                      bool coarse) {
  if (!samples.clear_of_saturation(index, 1.5 * sigma_px)) return {};
  const cv::Point2d out = samples.direction(index);
  const cv::Point2d middle = shape.centre + out * shape.radius_towards(out.x, out.y);
  Neighbours chosen{};
  const int others = choose_neighbours(neighbours, middle, samples.window_px(), sigma_px, chosen);
  const int degrees_of_freedom =
      static_cast<int>(samples.profile(index).intensity.size()) - kOwn - 2 * others - 2;
  if (degrees_of_freedom < kMinDegreesOfFreedom) return {};
  const auto nearest = std::span(chosen).first(static_cast<std::size_t>(others));
  const SectorTerms terms = terms_of(samples, index, shape, nearest, profiles, sigma_px);
  NormalEquations normal = products(terms);
  const double rise = rough_rise(normal);
  const auto free = normal.first_prior_term(), all = static_cast<std::size_t>(normal.linear);
  add_ridge(normal);
  NormalEquations freest = normal;
  project(freest, 0, free);
  const double noise2 = noise_of(freest, degrees_of_freedom);
  add_neighbours_prior(normal, nearest, rise, noise2);
  add_limb_prior(normal, rise, noise2);
  project(normal, 0, all);
  const Residuals residuals(normal, noise2);
  const auto shadow = residuals.shadow_depth(samples.window_px(), coarse);
  const bool rises = residuals.step() + residuals.root() * profiles.at(2.0 * sigma_px).root > 0.0;
  SectorEdge edge;
  if (shadow && rises) {
    edge = residuals.edge();
    edge.sd_px = std::hypot(edge.sd_px, *shadow);
  } else {
    edge.no_edge = true;
  }
  edge.step = residuals.step();
  edge.rise = residuals.step() + residuals.root();
  edge.rounding = residuals.root() * std::sqrt(sigma_px / samples.window_px());
  return edge;
}

}  // namespace strobe::digitize
