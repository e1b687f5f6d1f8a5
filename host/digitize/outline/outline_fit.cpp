#include "host/digitize/outline/outline_fit.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/outline/outline_sd.hpp"

namespace strobe::digitize {

namespace {

constexpr std::size_t kMinSamples = 5;
constexpr double kTukey2 = kBiweightReach_sd * kBiweightReach_sd;
constexpr double kMedianOfSquares = 1.386;  // of two normal numbers' sum

cv::Matx22d precision_of(const OvalSample& sample, double extra) {
  return (sample.covariance + cv::Matx22d::eye() * extra).inv(cv::DECOMP_CHOLESKY);
}

/// The variance beyond the samples' own that makes their residuals what they should be.
double extra_variance(std::span<const OvalSample> samples, const std::vector<cv::Vec2d>& residuals) {
  const auto middle = [&](double extra) {
    std::vector<double> squares;
    for (std::size_t i = 0; i < samples.size(); ++i)
      squares.push_back(residuals[i].dot(precision_of(samples[i], extra) * residuals[i]));
    return upper_median(std::move(squares));
  };
  double low = 0.0, high = 0.0;  // sds
  for (const cv::Vec2d& residual : residuals) high = std::max(high, cv::norm(residual));
  if (middle(0.0) <= kMedianOfSquares) return 0.0;
  for (int i = 0; i < 16; ++i) {
    const double half = 0.5 * (low + high);
    (middle(half * half) > kMedianOfSquares ? low : high) = half;
  }
  return high * high;
}

}  // namespace

cv::Matx23d OvalModel::terms(cv::Point2d plane_px) const {
  const cv::Point2d d = (plane_px - middle_) * (1.0 / reach_px_);
  return {1.0, 0.0, d.x * d.x - d.y * d.y, 0.0, 1.0, 2.0 * d.x * d.y};
}

cv::Vec2d OvalModel::at(cv::Point2d plane_px) const { return terms(plane_px) * unknowns_; }

cv::Matx22d OvalModel::covariance(cv::Point2d plane_px) const {
  const cv::Matx23d g = terms(plane_px);
  return g * unsure_ * g.t() + cv::Matx22d::eye() * (scatter_ * scatter_);
}

OvalModel::Pull OvalModel::pull(const OvalSample& sample, bool robust) const {
  const cv::Matx22d precision = precision_of(sample, scatter_ * scatter_);
  const cv::Vec2d residual = sample.oval - at(sample.at);
  const double z2 = robust ? residual.dot(precision * residual) / kTukey2 : 0.0;
  if (z2 >= 1.0) return {};
  const cv::Matx23d g = terms(sample.at);
  const cv::Matx32d weighted = (1.0 - z2) * (1.0 - z2) * (g.t() * precision);
  return {weighted * g, weighted * sample.oval};
}

void OvalModel::solve() {
  unsure_ = all_.normal.inv(cv::DECOMP_CHOLESKY);
  unknowns_ = unsure_ * all_.right;
}

OvalModel OvalModel::without(const OvalSample& sample) const {
  OvalModel others = *this;
  const Pull own = pull(sample);
  others.all_ = {all_.normal - own.normal, all_.right - own.right};
  others.solve();
  return others;
}

std::optional<OvalModel> fit_oval_model(std::span<const OvalSample> samples, cv::Point2d middle,
                                        double reach_px, double stretch_sd) {
  constexpr int kRounds = 6;
  if (samples.size() < kMinSamples) return std::nullopt;
  OvalModel agreed;
  agreed.middle_ = middle;
  agreed.reach_px_ = reach_px;
  std::vector<cv::Vec2d> residuals(samples.size());
  for (int round = 0; round <= kRounds; ++round) {
    OvalModel::Pull all;
    all.normal(0, 0) = all.normal(1, 1) = 1.0 / (kSquare_sd * kSquare_sd);
    all.normal(2, 2) = 1.0 / (stretch_sd * stretch_sd);
    for (const OvalSample& sample : samples) {
      const OvalModel::Pull own = agreed.pull(sample, round > 0);
      all.normal += own.normal;
      all.right += own.right;
    }
    agreed.all_ = all;
    // What without() takes away is what the last round added.
    if (round == kRounds) break;
    agreed.solve();
    for (std::size_t i = 0; i < samples.size(); ++i)
      residuals[i] = samples[i].oval - agreed.at(samples[i].at);
    agreed.scatter_ = std::sqrt(extra_variance(samples, residuals));
  }
  return agreed;
}

namespace {

using Vector = OutlineVector;
using Square = OutlineMatrix;

constexpr double kMinSigma_px = 0.289;  // of a pixel's own width: 1 over the root of 12
constexpr int kMinEdges = 6;

Vector gradient(cv::Point2d out) {
  const double c = out.x, s = out.y;
  return {c, s, 1.0, c * c - s * s, 2.0 * c * s};
}

/// One outline's fit, step by step.
class Fit {
 public:
  Fit(const SectorSamples& samples, std::span<const OutlineShape> neighbours,
      const OutlineFitSettings& settings, const OutlineShape& start, double sigma, double rounding_sd)
      : samples_(&samples),
        neighbours_(neighbours),
        settings_(settings),
        start_radius_(start.radius),
        oval_precision_(settings.oval_covariance.inv(cv::DECOMP_CHOLESKY) *
                        (1.0 / (start.radius * start.radius))),
        shape_(start),
        sigma_(sigma),
        rounding_sd_(rounding_sd) {
    for (int i = 0; i < samples.count(); ++i) gradients_.push_back(gradient(samples.direction(i)));
    offsets_.edges.resize(gradients_.size());
    offsets_.weight.assign(gradients_.size(), 0.0);
    offsets_.robust = offsets_.sensitivity = offsets_.common_sd = offsets_.weight;
  }

  /// Blur and shape change together (Gauss-Newton).
  bool step(bool coarse) {
    measure(coarse);
    solve({});
    const double grown = blur_change();
    for (SectorEdge& edge : offsets_.edges) edge.offset_px += edge.offset_by_sigma * grown;
    solve(change_);
    if (used() < kMinEdges) return false;
    const double most = 2.0 * std::max(sigma_, 0.7);
    sigma_ += grown;
    Vector change = change_;
    const double longest = std::max({std::abs(change[0]), std::abs(change[1]), std::abs(change[2])});
    if (longest > most) change *= most / longest;
    shape_.centre += cv::Point2d(change[0], change[1]);
    shape_.radius += change[2];
    shape_.oval_cos += change[3];
    shape_.oval_sin += change[4];
    return true;
  }

  /// Half an outline hardly tells its radius and its centre apart, and reaches them in small steps.
  bool is_moving() const {
    constexpr double kSettled_px = 0.05;
    return offsets_.half_lit && 4 * used() >= count() &&
           std::max({std::abs(change_[0]), std::abs(change_[1]), std::abs(change_[2])}) > kSettled_px;
  }

  /// After the last step.
  FittedOutline result() const {
    FittedOutline fitted;
    fitted.shape = shape_;
    fitted.sigma_px = sigma_;
    const std::vector<double> left = residuals(change_);
    summarize(fitted);
    const bool cut_off = fitted.outside_fraction > 0.25;
    const OutlineSd sd = outline_covariance(
        {offsets_, gradients_, left, sigma_, shape_.radius, samples_->window_px(), cut_off}, prior(),
        rounding_sd_);
    fitted.covariance = sd.covariance;
    fitted.shared_radius_sd_px = sd.shared_radius_px;
    assert(is_covariance(fitted.covariance));
    return fitted;
  }

 private:
  int count() const { return samples_->count(); }

  int used() const {
    return static_cast<int>(
        std::count_if(offsets_.robust.begin(), offsets_.robust.end(), [](double t) { return t > 0.1; }));
  }

  void measure(bool coarse) {
    const double most = 2.0 * std::max(sigma_, 0.7);
    const ProfileTable profiles = sector_profiles(*samples_, shape_.radius, sigma_);
    for (int i = 0; i < count(); ++i) {
      SectorEdge& edge = offsets_.edges[static_cast<std::size_t>(i)];
      edge = fit_sector(*samples_, i, shape_, neighbours_, profiles, sigma_, coarse);
      edge.offset_px = std::clamp(edge.offset_px, -most, most);
    }
    if (!coarse) downweight_shadow(offsets_, sigma_);
  }

  double residual(int i, const Vector& change) const {
    const auto at = static_cast<std::size_t>(i);
    return offsets_.edges[at].offset_px - gradients_[at].dot(change);
  }

  std::vector<double> residuals(const Vector& change) const {
    std::vector<double> left;
    for (int i = 0; i < count(); ++i) left.push_back(residual(i, change));
    return left;
  }

  /// Iteratively reweighted.
  void solve(const Vector& from) {
    constexpr int kRounds = 5;
    change_ = from;
    for (int round = 0; round < kRounds; ++round) {
      reweight(offsets_, residuals(change_));
      Square normal = prior();
      Vector right = prior_right();
      for (std::size_t i = 0; i < gradients_.size(); ++i) {
        const double w = offsets_.weight[i];
        if (w == 0.0) continue;
        const Vector& g = gradients_[i];
        for (int a = 0; a < kOutlineParameters; ++a) {
          for (int b = 0; b <= a; ++b) normal(a, b) += w * g[a] * g[b];
          right[a] += w * offsets_.edges[i].offset_px * g[a];
        }
      }
      for (int a = 0; a < kOutlineParameters; ++a)
        for (int b = a + 1; b < kOutlineParameters; ++b) normal(a, b) = normal(b, a);
      change_ = normal.solve(right, cv::DECOMP_CHOLESKY);
    }
  }

  double radius_precision() const {
    return settings_.radius_px && settings_.radius_sd_px
               ? 1.0 / std::pow(std::max(*settings_.radius_sd_px, 1e-3), 2)
               : 0.0;
  }
  Square prior() const {
    Square p = Square::zeros();
    p(0, 0) = p(1, 1) = 1e-6;
    p(2, 2) = 1e-6 + radius_precision();
    for (int a = 0; a < 2; ++a)
      for (int b = 0; b < 2; ++b) p(3 + a, 3 + b) = oval_precision_(a, b);
    return p;
  }
  /// The prior's part of the normal equations' right-hand side.
  Vector prior_right() const {
    const double known = settings_.radius_px ? *settings_.radius_px - shape_.radius : 0.0;
    const cv::Vec2d oval =
        oval_precision_ * (settings_.oval * start_radius_ - cv::Vec2d(shape_.oval_cos, shape_.oval_sin));
    return {0.0, 0.0, radius_precision() * known, oval[0], oval[1]};
  }

  double blur_change() const {
    double change = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < offsets_.edges.size(); ++i) {
      change += offsets_.robust[i] * offsets_.edges[i].sigma_change;
      weight += offsets_.robust[i] * offsets_.edges[i].sigma_weight;
    }
    if (weight <= 0.0) return 0.0;
    const double grown = std::clamp(change / weight, -0.4 * sigma_, 0.4 * sigma_);
    return std::max(kMinSigma_px, sigma_ + grown) - sigma_;
  }

  void summarize(FittedOutline& fitted) const {
    double squares = 0.0, trusts = 0.0;
    int seen = 0;
    std::vector<bool> visible(static_cast<std::size_t>(count()));
    std::vector<double> rises;
    for (int i = 0; i < count(); ++i) {
      const auto at = static_cast<std::size_t>(i);
      squares += offsets_.robust[at] * std::pow(residual(i, change_), 2);
      trusts += offsets_.robust[at];
      visible[at] = offsets_.robust[at] > 0.1;
      seen += visible[at] ? 1 : 0;
      if (visible[at]) rises.push_back(offsets_.edges[at].rise);
      fitted.saturated_fraction += (samples_->saturated_fraction(i) > 0.3 ? 1.0 : 0.0) / count();
      fitted.outside_fraction += (samples_->inside_fraction(i) < 0.5 ? 1.0 : 0.0) / count();
    }
    fitted.visible_fraction = static_cast<double>(seen) / count();
    fitted.rms_px = trusts > 0.0 ? std::sqrt(squares / trusts) : 0.0;
    fitted.visible_arcs = arcs(visible);
    fitted.shape.rise = rises.empty() ? 0.0 : median(std::move(rises));
  }

  std::vector<Arc> arcs(const std::vector<bool>& seen) const {
    const double turn = 2.0 * std::numbers::pi;
    const int n = count();
    const auto at = [&](int i) { return seen[static_cast<std::size_t>((i + n) % n)]; };
    if (std::all_of(seen.begin(), seen.end(), [](bool s) { return s; })) return {{0.0, turn}};
    std::vector<Arc> found;
    for (int i = 0; i < n; ++i) {
      if (!at(i) || at(i - 1)) continue;
      int length = 1;
      while (at(i + length)) ++length;
      found.push_back({turn * i / n, turn * length / n});
    }
    return found;
  }

  const SectorSamples* samples_;
  std::span<const OutlineShape> neighbours_;
  OutlineFitSettings settings_;
  double start_radius_;
  cv::Matx22d oval_precision_;  ///< prior's
  OutlineShape shape_;
  double sigma_;
  double rounding_sd_;
  SectorOffsets offsets_;
  std::vector<Vector> gradients_;  ///< of the radius by the unknowns, by sector
  Vector change_{};
};

}  // namespace

std::optional<FittedOutline> fit_outline(const Photograph& photograph, const LocalFrame& frame,
                                         const OutlineShape& start, double sigma_px,
                                         std::span<const OutlineShape> neighbours,
                                         const OutlineFitSettings& settings) {
  const int sectors =
      std::clamp(static_cast<int>(2.0 * std::numbers::pi * start.radius / settings.sectors_px), 24, 160);
  const double most = 0.3 * start.radius;
  const double length = 2.0 * std::numbers::pi * start.radius / sectors;
  const SectorGrid grid{sectors, std::max(2, static_cast<int>(length / settings.rays_px + 0.5)),
                        std::min(most, 3.0 * sigma_px + settings.outside_px),
                        std::min(most, 3.0 * sigma_px + settings.inside_px)};
  const SectorSamples samples(photograph, frame, start, grid);
  Fit fit(samples, neighbours, settings, start, sigma_px, photograph.rounding_sd());
  for (int step = 0; step < settings.steps; ++step)
    if (!fit.step(step < settings.coarse_steps)) return std::nullopt;
  for (int further = 0; further < settings.further_steps && fit.is_moving(); ++further) {
    Fit next = fit;
    if (!next.step(false)) break;
    fit = std::move(next);
  }
  return fit.result();
}

void apply_oval_prior(FittedOutline& fitted, cv::Vec2d oval, const cv::Matx22d& covariance,
                      const cv::Matx22d& former) {
  OutlineShape& shape = fitted.shape;
  // Only the new information: precisions add up, and so do their products with the expected values.
  const cv::Matx22d precision = covariance.inv(cv::DECOMP_CHOLESKY);
  const cv::Matx22d added = precision - former.inv(cv::DECOMP_CHOLESKY);
  assert(added(0, 0) > 0.0 && cv::determinant(added) > 0.0);
  const cv::Matx22d variance = added.inv(cv::DECOMP_CHOLESKY) * (shape.radius * shape.radius);
  const cv::Vec2d expected = variance * precision * oval * (1.0 / shape.radius);
  const cv::Vec2d off = expected - cv::Vec2d(shape.oval_cos, shape.oval_sin);
  const Square before = fitted.covariance;
  const cv::Matx22d spread = before.get_minor<2, 2>(3, 3) + variance;
  if (off.dot(spread.inv() * off) > kFarthest_sd * kFarthest_sd) return;
  const cv::Matx<double, kOutlineParameters, 2> gain =
      before.get_minor<kOutlineParameters, 2>(0, 3) * spread.inv();
  const cv::Matx<double, kOutlineParameters, 1> change = gain * off;
  shape.centre += cv::Point2d(change(0), change(1));
  shape.radius += change(2);
  shape.oval_cos += change(3);
  shape.oval_sin += change(4);
  // Joseph's form stays positive semi-definite where one outline tells next to nothing.
  Square kept = Square::eye();
  for (int a = 0; a < kOutlineParameters; ++a)
    for (int b = 0; b < 2; ++b) kept(a, 3 + b) -= gain(a, b);
  fitted.covariance = kept * before * kept.t() + gain * variance * gain.t();
  assert(is_covariance(fitted.covariance));
}

}  // namespace strobe::digitize
