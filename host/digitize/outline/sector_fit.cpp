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
constexpr int kSlope = 1, kStep = 2, kRoot = 3, kInnerSlope = 4;
constexpr int kLimb = kStep, kDeviation = kRoot;  // by add_limb_prior()
constexpr int kLanes = 4;
constexpr int kMaxDepths = SectorSamples::kMaxDepths;
constexpr int kMinDegreesOfFreedom = 4;
constexpr double kCoarseSd = 2.0;
// Prior for a neighbour's amplitudes, about thirty times the noise around zero: without it a limb parallel to
// this one would explain all of its profile.
constexpr double kNeighbourPrior = 1e-3;
// Bilinear interpolation removes a third of white noise's variance, but not its slow part, which makes the
// fit's error (a cubic B-spline's values at 0, ±1: 2/3, 1/6).
constexpr double kInterpolation = 1.5;

/// The sector's intensity and the model's terms, a row each, by depth.
struct Terms {
  alignas(16) std::array<std::array<float, kMaxDepths>, kMaxTerms> row;
  int linear = kOwn;
  int depths = 0;

  int count() const { return linear + kExtra; }
  void pad() {
    while (depths % kLanes != 0) {
      for (int i = 0; i < count(); ++i)
        row[static_cast<std::size_t>(i)][static_cast<std::size_t>(depths)] = 0.0F;
      ++depths;
    }
  }
};

struct Normal {
  std::array<std::array<double, kMaxTerms>, kMaxTerms> m;
  int linear = kOwn;
};

Normal products(const Terms& terms) {
  Normal normal;
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

void add_neighbour(Terms& terms, std::size_t first, const SectorSamples& samples, int index, double shift,
                   const OutlineShape& other, const ProfileTable& profiles) {
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

Terms terms_of(const SectorSamples& samples, int index, const OutlineShape& shape,
               std::span<const OutlineShape* const> neighbours, const ProfileTable& profiles, double sigma) {
  Terms terms;
  terms.linear = kOwn + 2 * static_cast<int>(neighbours.size());
  const SectorSamples::Profile profile = samples.profile(index);
  const double shift = inward_shift(shape.radius, sigma);
  const double moved = profile.depth_px + shape.depth(samples.middle(index)) - shift;
  const double unit = 1.0 / samples.window_px();
  const auto extra = static_cast<std::size_t>(terms.linear);
  for (std::size_t k = 0; k < profile.intensity.size(); ++k) {
    const double depth = moved + static_cast<double>(k) * samples.depth_step_px();
    const ProfileTable::Entry entry = profiles.at(depth);
    const auto inwards = static_cast<float>(depth * unit);
    terms.row[0][k] = 1.0F;
    terms.row[kSlope][k] = inwards;
    terms.row[kStep][k] = entry.step;
    terms.row[kRoot][k] = entry.root;
    terms.row[kInnerSlope][k] = entry.step * inwards;
    terms.row[extra][k] = entry.step_by_depth;
    terms.row[extra + 1][k] = entry.root_by_depth;
    terms.row[extra + 2][k] = entry.step_by_sigma;
    terms.row[extra + 3][k] = entry.root_by_sigma;
    terms.row[extra + 4][k] = profile.intensity[k];
  }
  std::size_t next = kOwn;
  for (const OutlineShape* other : neighbours) {
    add_neighbour(terms, next, samples, index, shift, *other, profiles);
    next += 2;
  }
  terms.depths = static_cast<int>(profile.intensity.size());
  terms.pad();
  return terms;
}

// What is known of a limb before its sector is seen. Of its rise over a window, the part that grows as the root
// is anything from none (light from all around, fuzz) to all (a matt sphere lit from the camera): uniform, with
// the mean 1/2 and the variance 1/12. A window is at most .3 of a radius deep, and light on a sphere, this one or
// one behind it, changes by as much as it is over a radius: slopes of ball and background are within .3 of it.
constexpr double kRootShare = 0.5, kRootShareVariance = 1.0 / 12.0, kSlopeVariance = 0.3 * 0.3;

/// Replaces term `to` by itself plus `factor` times term `from`.
void mix(Normal& normal, std::size_t to, std::size_t from, double factor) {
  const auto terms = static_cast<std::size_t>(normal.linear + kExtra);
  const auto at = [&](std::size_t i, std::size_t j) -> double& {
    return normal.m[std::max(i, j)][std::min(i, j)];
  };
  const double own = at(to, to) + 2 * factor * at(to, from) + factor * factor * at(from, from);
  for (std::size_t i = 0; i < terms; ++i)
    if (i != to) at(i, to) += factor * at(i, from);
  at(to, to) = own;
}

/// Rise of intensity over the limb, with nothing but an even background fitted beside it.
double rough_rise(const Normal& normal) {
  const auto light = static_cast<std::size_t>(normal.linear + kExtra - 1);
  const double mean = normal.m[kLimb][0] / normal.m[0][0];
  const double own = normal.m[kLimb][kLimb] - mean * normal.m[kLimb][0];
  return own > 0.0 ? (normal.m[light][kLimb] - mean * normal.m[light][0]) / own : 0.0;
}

/// Makes step and root a limb of even shares and its deviation from it, which, like the slopes, is expected to
/// be small against the limb's rise: by as much as noise, texture among it, hides. Without noise nothing is
/// assumed; in bad light, where the terms are nearly collinear, the limb is of the common shape.
void add_limb_prior(Normal& normal, double noise2) {
  mix(normal, kDeviation, kLimb, -1.0);
  mix(normal, kLimb, kDeviation, kRootShare);
  const double relative = noise2 / (std::pow(rough_rise(normal), 2) + noise2);
  normal.m[kSlope][kSlope] += relative / kSlopeVariance;
  normal.m[kDeviation][kDeviation] += relative / kRootShareVariance;
  normal.m[kInnerSlope][kInnerSlope] += relative / kSlopeVariance;
}

/// Projects the linear terms out of the others by a Cholesky factorization, row by row: afterwards m[i][j] of
/// the others holds the products of their residuals, and m[last][j] of a linear term j holds (L⁻¹ b)_j, b
/// being its products with the intensity.
void project(Normal& normal) {
  const auto linear = static_cast<std::size_t>(normal.linear), terms = linear + kExtra;
  for (std::size_t j = 0; j < linear; ++j)
    normal.m[j][j] = (1.0 + 1e-6) * normal.m[j][j] + (j < kOwn ? 0.0 : kNeighbourPrior);
  for (std::size_t i = 0; i < terms; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = normal.m[i][j];
      for (std::size_t k = 0; k < std::min(j, linear); ++k) sum -= normal.m[i][k] * normal.m[j][k];
      if (j >= linear) {
        normal.m[i][j] = sum;
      } else if (i == j) {
        normal.m[i][i] = std::sqrt(std::max(sum, 1e-9));
      } else {
        normal.m[i][j] = sum / normal.m[j][j];
      }
    }
  }
}

/// The linear terms' amplitudes, by back substitution.
std::array<double, kMaxLinear> coefficients(const Normal& normal) {
  std::array<double, kMaxLinear> x{};
  const int linear = normal.linear;
  const auto& intensity = normal.m[static_cast<std::size_t>(linear + kExtra - 1)];
  for (int i = linear - 1; i >= 0; --i) {
    const auto row = static_cast<std::size_t>(i);
    double sum = intensity[row];
    for (int k = i + 1; k < linear; ++k)
      sum -= normal.m[static_cast<std::size_t>(k)][row] * x[static_cast<std::size_t>(k)];
    x[row] = sum / normal.m[row][row];
  }
  return x;
}

/// Variance of the intensity around the freest of the models: project() of the intensity alone.
double noise_of(const Normal& normal, int degrees_of_freedom) {
  std::array<std::array<double, kMaxLinear>, kMaxLinear + 1> factor;
  const auto linear = static_cast<std::size_t>(normal.linear), light = linear + kExtra - 1;
  double left = normal.m[light][light];
  for (std::size_t i = 0; i <= linear; ++i) {
    const auto& products = normal.m[i < linear ? i : light];
    for (std::size_t j = 0; j < std::min(i + 1, linear); ++j) {
      double sum = products[j];
      if (i == j) sum += 1e-6 * sum + (j < kOwn ? 0.0 : kNeighbourPrior);
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i][k] * factor[j][k];
      factor[i][j] = i == j ? std::sqrt(std::max(sum, 1e-9)) : sum / factor[j][j];
      if (i == linear) left -= factor[i][j] * factor[i][j];
    }
  }
  return kInterpolation * std::max(left, 0.0) / degrees_of_freedom + 1e-14;
}

/// Products of a sector's residuals after projection, for the fitted amplitudes of step and root.
class Residuals {
 public:
  Residuals(const Normal& normal, double noise2)
      : normal_(normal), noise2_(noise2), first_(static_cast<std::size_t>(normal.linear)) {
    const auto x = coefficients(normal);
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
    std::array<double, kMaxLinear> unit{};
    double variance = 0.0, shared = 0.0;
    for (std::size_t i = kLimb; i < first_; ++i) {
      double sum = i == kLimb ? 1.0 - kRootShare : i == kDeviation ? -1.0 : 0.0;
      for (std::size_t k = kLimb; k < i; ++k) sum -= normal_.m[i][k] * unit[k];
      unit[i] = sum / normal_.m[i][i];
      variance += unit[i] * unit[i];
      shared += unit[i] * (step_ * normal_.m[first_][i] + root_ * normal_.m[first_ + 1][i]);
    }
    return {std::sqrt(noise2_ * variance), std::sqrt(noise2_ * (variance + shared * shared / depth_depth_)),
            shared};
  }

  const Normal& normal_;
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
  const Terms terms = terms_of(samples, index, shape,
                               std::span(chosen).first(static_cast<std::size_t>(others)), profiles, sigma_px);
  Normal normal = products(terms);
  const double noise2 = noise_of(normal, degrees_of_freedom);
  add_limb_prior(normal, noise2);
  project(normal);
  const Residuals residuals(normal, noise2);
  const auto shadow = residuals.shadow_depth(samples.window_px(), coarse);
  if (!shadow || !(residuals.step() + residuals.root() * profiles.at(2.0 * sigma_px).root > 0.0)) {
    SectorEdge none;
    none.no_edge = true;
    return none;
  }
  SectorEdge edge = residuals.edge();
  edge.sd_px = std::hypot(edge.sd_px, *shadow);
  const double rounding = std::max(0.0, residuals.root()) * std::sqrt(sigma_px / samples.window_px());
  edge.limb_ratio = rounding / std::max(residuals.step(), 1e-3 * rounding);
  return edge;
}

}  // namespace strobe::digitize
