#include "host/digitize/surface/edge_refinement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/surface/edge_line.hpp"

namespace strobe::digitize {
namespace {

constexpr int kMaxSteps = 20;
constexpr double kConverged_px = 1e-3;
constexpr double kMaxAway_px = 2.0 * kInlier_px;  // farther off it is another edge
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
  // A step that ends at saturation fits what is saturated without fitting the rest, and is hard to leave from
  // below.
  first.height *= 2.0;
  fitter.ignore_saturated(true);
  const auto fit = fit_from(fitter, first, start);
  fitter.ignore_saturated(false);
  if (!fit) return std::nullopt;
  return fit_from(fitter, {fit->background, fit->step, fit->at}, start);
}

namespace {

constexpr std::size_t kMinProfiles = 12;
// Profiles of one block err alike. Long blocks hold what a scratch or uneven light does; but errors that come
// and go with the edge's place between two rows cancel within them and not at the line's ends, as short ones
// tell.
constexpr std::size_t kLongBlocks = 8, kShortBlocks = 24;
constexpr std::size_t kProfilesForBlur = 24;
// Of any lens that is in focus, up to where the samples' reach holds 3 sd.
constexpr double kMinBlur_px = 0.2, kBlurRatio = 1.5;
constexpr double kMaxBlur_px = kProfileHalfReach_px / 3.0;
constexpr int kRounds = 6;
// The steepest rise of an edge that is cut off is anywhere up to kMaxAway_px to the dark side of it: rms.
constexpr double kCutOff_px = kMaxAway_px * std::numbers::inv_sqrt3;

struct Profile {
  EdgeSamples samples;
  int column = 0;
  double along = 0.0;              ///< the photograph, 0 to 1
  double start = 0.0;              ///< index of the samples
  double least = 0.0, most = 0.0;  ///< of the samples
};

/// Where the edge crosses a profile. Plane px from the middle of the edge that is refined.
struct Place {
  double x = 0.0, y = 0.0;
  double along = 0.0;  ///< the photograph, 0 to 1
  double weight = 1.0;
};

/// Height at x = 0, and slope.
using Coefficients = Eigen::Vector2d;

double off(const Coefficients& line, const Place& p) { return p.y - line[0] - line[1] * p.x; }

struct NormalEquations {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  void add(const Place& p) {
    const Eigen::Vector2d by(1.0, p.x);
    matrix += p.weight * by * by.transpose();
    right += p.weight * p.y * by;
  }
  Coefficients solve() const { return matrix.ldlt().solve(right); }
};

/// By iteratively reweighted least squares; leaves the weights in the places.
Coefficients robust_line(std::vector<Place>& places, double slope) {
  std::vector<double> values;
  for (const Place& p : places) values.push_back(p.y - slope * p.x);
  Coefficients line(upper_median(std::move(values)), slope);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> away;
    for (const Place& p : places) away.push_back(std::abs(off(line, p)));
    const double reach = std::max(1e-9, kBiweightReach_sd * kSdOverMad * upper_median(std::move(away)));
    NormalEquations equations;
    for (Place& p : places) {
      const double share = off(line, p) / reach;
      p.weight = std::abs(share) < 1.0 ? (1.0 - share * share) * (1.0 - share * share) : 0.0;
      equations.add(p);
    }
    line = equations.solve();
  }
  return line;
}

/// By the jackknife, a block left out at a time (Efron and Tibshirani, An introduction to the bootstrap,
/// 1993, chapter 11).
Eigen::Matrix2d covariance(const std::vector<Place>& places, const Coefficients& line, std::size_t count) {
  NormalEquations all;
  std::vector<NormalEquations> blocks(count);
  for (Place p : places) {
    p.y = off(line, p);
    all.add(p);
    blocks[static_cast<std::size_t>(p.along * static_cast<double>(count))].add(p);
  }
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  double used = 0.0;
  for (const NormalEquations& block : blocks) {
    if (block.matrix(0, 0) <= 0.0) continue;
    used += 1.0;
    const NormalEquations others{all.matrix - block.matrix, all.right - block.right};
    const Coefficients without = others.solve();
    sum += without * without.transpose();
  }
  // Two of the blocks' degrees of freedom are the line's; two more make up for the few others (Student's t).
  if (used < 5.0) return Eigen::Matrix2d::Identity();
  return sum * ((used - 1.0) / used * (used - 2.0) / (used - 4.0));
}

/// Of height and slope.
Eigen::Vector2d variances(const std::vector<Place>& places, const Coefficients& line) {
  return 0.5 * (covariance(places, line, kLongBlocks) + covariance(places, line, kShortBlocks)).diagonal();
}

class Profiles {
 public:
  Profiles(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
           const EdgeLine& edge)
      : photograph_(photograph), map_(map), edge_(edge) {
    const int count = profile_count(photograph);
    for (int i = 0; i < count; ++i) {
      const int column = profile_column(photograph, i);
      const double row = row_of(column);
      const auto samples = samples_across(photograph, occluded, column, row);
      if (!samples) continue;
      const auto [least, most] = std::ranges::minmax(samples->intensity);
      profiles_.push_back({*samples, column, (i + 0.5) / count, row - samples->top, least, most});
    }
  }

  /// The blur that leaves the least residuals: of a coarse grid, then thrice a parabola's.
  StepShape shape(Blur blur) const {
    StepShape best{blur, kMinBlur_px};
    double least = 1e300;
    const auto attempt = [&](double sd_px) {
      const double of = misfit({blur, sd_px});
      if (of < least) least = of, best.sd_px = sd_px;
      return of;
    };
    for (double sd_px = kMinBlur_px; sd_px < kMaxBlur_px; sd_px *= kBlurRatio) attempt(sd_px);
    for (const double ratio : {1.2, 1.06, 1.02}) {
      const double middle = best.sd_px, of = least;
      const double below = attempt(middle / ratio), above = attempt(middle * ratio);
      const double bend = below - 2.0 * of + above;
      if (bend > 0.0) attempt(middle * std::pow(ratio, std::clamp(0.5 * (below - above) / bend, -1.0, 1.0)));
    }
    return best;
  }

  std::size_t size() const { return profiles_.size(); }
  bool saturated() const {
    return std::ranges::any_of(profiles_, [&](const Profile& p) { return p.most >= full(); });
  }

  std::vector<Place> places(const StepShape& shape) const {
    std::vector<Place> places;
    for (const Profile& profile : profiles_) {
      const auto fit = fit_step(profile.samples.intensity, full(), profile.start, shape);
      if (!fit) continue;
      const cv::Point2d at =
          map_.to_plane({static_cast<double>(profile.column), profile.samples.top + fit->at}) - edge_.middle;
      places.push_back({at.x, at.y, profile.along});
    }
    return places;
  }

 private:
  double full() const { return kSaturatedShare * static_cast<double>(photograph_.saturation); }

  /// The edge's row in a column of the photograph.
  double row_of(int column) const {
    cv::Point2d image(column, 0.5 * photograph_.height());
    for (int k = 0; k < 4; ++k)
      image.y = map_.to_image({map_.to_plane(image).x, edge_.at(map_.to_plane(image).x)}).y;
    return image.y;
  }

  /// Of the three quarters that fit best: scratches do not count.
  double misfit(const StepShape& shape) const {
    const std::size_t every = std::max<std::size_t>(1, profiles_.size() / kProfilesForBlur);
    std::vector<double> squares;
    for (std::size_t i = 0; i < profiles_.size(); i += every) {
      const Profile& p = profiles_[i];
      const auto fit = fit_step(p.samples.intensity, full(), p.start, shape);
      squares.push_back(fit ? fit->squares / ((p.most - p.least) * (p.most - p.least)) : 1.0);
    }
    std::ranges::sort(squares);
    squares.resize(squares.size() * 3 / 4);
    double sum = 0.0;
    for (const double s : squares) sum += s;
    return sum;
  }

  const Photograph& photograph_;
  const PlaneMap& map_;
  const EdgeLine& edge_;
  std::vector<Profile> profiles_;
};

EdgeLine as_it_is(EdgeLine edge, bool saturated) {
  if (saturated) edge.sd_px = std::hypot(edge.sd_px, kCutOff_px);
  return edge;
}

}  // namespace

EdgeLine refine_edge_line(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
                          const EdgeLine& edge) {
  const Profiles profiles(photograph, map, occluded, edge);
  std::vector<Place> places = profiles.places(profiles.shape(Blur::normal));
  if (places.size() < kMinProfiles) return as_it_is(edge, profiles.saturated());
  const Coefficients line = robust_line(places, edge.slope);
  Eigen::Vector2d variance = variances(places, line);
  if (profiles.saturated()) {
    // What tails the lens's blur has is not known, and they place an edge of which only the foot is seen.
    std::vector<Place> others = profiles.places(profiles.shape(Blur::logistic));
    if (others.size() < kMinProfiles) return as_it_is(edge, true);
    const Coefficients by_tails = robust_line(others, edge.slope) - line;
    variance += by_tails.cwiseAbs2();
  }
  if (!line.allFinite() || !variance.allFinite()) return edge;
  EdgeLine refined = edge;
  refined.middle.y += line[0];
  refined.slope = line[1];
  refined.sd_px = std::hypot(std::sqrt(variance[0]), kEdgeFloor_px);
  refined.slope_sd = std::sqrt(variance[1]);
  return refined;
}

}  // namespace strobe::digitize
