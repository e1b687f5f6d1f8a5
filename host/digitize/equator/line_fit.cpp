#include "host/digitize/equator/line_fit.hpp"

#include <algorithm>
#include <cmath>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr int kMaxSegments = 24;
constexpr double kMinSegment_px = 5.0;
constexpr int kRounds = 3;
constexpr double kFlat_rad = 0.1;  ///< less tilted, a line is a diameter as far as segments are concerned

using SegmentTerms = cv::Vec<double, 5>;
using SegmentNormal = cv::Matx<double, 5, 5>;

/// Least squares of one segment: level, gradient, darkness, shift times contrast, and the share by which the
/// neighbours' light was subtracted amiss, which makes a step where a neighbour's image ends.
struct Sums {
  SegmentNormal normal;
  SegmentTerms right;
  SegmentTerms widening;  ///< the right side of a line whose half width is a radius more
  double square = 0.0;
  double along = 0.0;
  double weight = 0.0;
  double others = 0.0;  ///< the neighbours' light over the ball's
  double count = 0.0;
  double information = 0.0;  ///< weight on the line's flanks
};

struct Segments {
  std::vector<Segment> segments;
  std::vector<double> shift;           ///< times contrast
  std::vector<double> shift_variance;  ///< up to the common factor
  double residual = 0.0;               ///< sum of squares within the segments
  double degrees_of_freedom = 0.0;
};

void add(Sums& s, const LinePoint& point, double along, double f, double dark, double derivative,
         double contrast) {
  const double w = point.weight;
  // Residuals of shading and felt are proportional to the intensity, on the line too.
  const double lit = 1.0 - contrast * dark;
  const double level = w * lit, gradient = level * f, x = point.x;
  s.normal(0, 0) += level * lit;
  s.normal(1, 0) += gradient * lit;
  s.normal(1, 1) += gradient * f * lit;
  s.right[0] += level * x;
  s.right[1] += gradient * x;
  // Light adds up, and the variance is the sum of the squares.
  const double others = std::sqrt(std::max(0.0, 1.0 / w - 1.0));
  s.others += w * others;
  s.normal(4, 0) += level * others;
  s.normal(4, 1) += gradient * others;
  s.normal(4, 4) += w * others * others;
  s.right[4] += w * others * x;
  s.square += w * x * x;
  s.weight += w;
  s.count += 1.0;
  if (dark == 0.0) return;
  s.normal(2, 0) -= level * dark;
  s.normal(2, 1) -= gradient * dark;
  s.normal(2, 2) += w * dark * dark;
  s.normal(3, 0) += level * derivative;
  s.normal(3, 1) += gradient * derivative;
  s.normal(3, 2) -= w * dark * derivative;
  s.normal(4, 2) -= w * others * dark;
  s.normal(4, 3) += w * others * derivative;
  const double information = w * derivative * derivative;
  s.normal(3, 3) += information;
  s.right[2] -= w * dark * x;
  s.right[3] += w * derivative * x;
  // Both edges move outwards: derivative is positive below the line and negative above.
  const double wider = -w * std::abs(derivative);
  s.widening += wider * SegmentTerms(lit, lit * f, -dark, derivative, others);
  s.along += information * along;
  s.information += information;
}

/// Where the half ellipse is cut, and how dark it is across.
class Cuts {
 public:
  Cuts(const EquatorLine& line, double radius) : line_(line), most_(kInner) {
    const double length = std::abs(line.tilt_rad) < kFlat_rad ? 2.0 * kInner : lengths();
    count_ = std::clamp(static_cast<int>(length * radius / kMinSegment_px), 6, kMaxSegments);
    LineShape shape = line.shape;
    for (int k = 0; k == 0 || (k < kShapes && !length_.empty()); ++k) {
      shapes_.emplace_back(shape);
      shape.soft *= kSteepnessStep;
    }
  }

  int count() const { return count_; }
  /// Of a point's u'; outside of 0 to count() - 1 beyond the ends.
  int segment(double along) const {
    const double place = (along / most_ + 1.0) * 0.5;
    if (length_.empty()) return static_cast<int>(place * count_);
    if (!(place >= 0.0 && place < 1.0)) return -1;
    const double step = place * kSteps;
    const auto k = static_cast<std::size_t>(step);
    const double share = length_[k] + (step - static_cast<double>(k)) * (length_[k + 1] - length_[k]);
    return static_cast<int>(share * count_);
  }
  /// Where f is that steep: the blur is one of the photograph.
  const ShapeTable& shape(double steepness) const {
    if (length_.empty()) return shapes_.front();
    const double place = std::log(steepness) * (1.0 / std::log(kSteepnessStep)) + 0.5;
    return shapes_[static_cast<std::size_t>(std::clamp(place, 0.0, kShapes - 1.0))];
  }
  /// How far from the line's middle the ball's own brightness is measured.
  double far() const { return within(shape(1.0 / std::cos(line_.tilt_rad))); }
  static double within(const ShapeTable& shape) { return 1.7 * shape.reach() + 0.02; }

 private:
  static constexpr int kSteps = 128;
  static constexpr int kShapes = 30;  ///< to a steepness of 4
  static constexpr double kSteepnessStep = 1.05;

  /// Returns the length of what is within kInner. [radii]
  double lengths() {
    const double cosine = std::cos(line_.tilt_rad), tangent = std::tan(line_.tilt_rad);
    most_ = std::sqrt(std::max(0.04, 1.0 - (1.0 - kInner * kInner) / (cosine * cosine)));
    length_.push_back(0.0);
    const double tilted = tangent * tangent * cosine * cosine;
    for (int k = 0; k < kSteps; ++k) {
      const double along = most_ * (2.0 * (k + 0.5) / kSteps - 1.0), along2 = along * along;
      const double slope2 = tilted * along2 / (1.0 - along2);
      length_.push_back(length_.back() + std::sqrt(1.0 + slope2) * 2.0 * most_ / kSteps);
    }
    const double all = length_.back();
    for (double& length : length_) length /= all;
    return all;
  }

  const EquatorLine& line_;
  double most_;  ///< u' of the ends
  int count_ = 0;
  std::vector<double> length_;  ///< from the one end, as a share, at even u'; empty: proportional to u'
  std::vector<ShapeTable> shapes_;
};

/// Blur moves a dark line towards what is brighter and to the inner side of its bend.
class Blurred {
 public:
  Blurred(const EquatorLine& line, double blur)
      : coordinates_(line), variance_(std::pow(std::min(blur, line.shape.soft), 2)) {}
  double along(const LinePoint& p) const { return coordinates_.along(p.u, p.v); }
  /// And how steep that is.
  std::pair<double, double> across(const LinePoint& p) const {
    const double u = p.u, v = p.v, z = p.z;
    const cv::Point2d steep = coordinates_.gradient(u, v, z);
    const double bend = 0.5 * coordinates_.sin_tilt() * (1.0 + z * z) / (z * z * z);
    return {coordinates_.across(u, v, z) + variance_ * (bend + steep.x * p.slope.x + steep.y * p.slope.y),
            std::hypot(steep.x, steep.y)};
  }

 private:
  LineCoordinates coordinates_;
  double variance_;
};

std::vector<Sums> sum_segments(std::span<const LinePoint> points, const EquatorLine& line, const Cuts& cuts,
                               double blur) {
  std::vector<Sums> sums(static_cast<std::size_t>(cuts.count()));
  const Blurred coordinates(line, blur);
  for (const LinePoint& point : points) {
    const auto [f, steepness] = coordinates.across(point);
    const ShapeTable& shape = cuts.shape(steepness);
    if (std::abs(f) > Cuts::within(shape)) continue;
    const double along = coordinates.along(point);
    const int which = cuts.segment(along);
    if (which < 0 || which >= cuts.count()) continue;
    const auto [dark, derivative] = shape.at(f);
    add(sums[static_cast<std::size_t>(which)], point, along, f, dark, derivative, line.contrast);
  }
  return sums;
}

/// From here on the neighbours' light counts by how it differs from its mean: even, it is told from the
/// ball's by the line's darkness only.
void centre_others(Sums& s, double contrast) {
  SegmentNormal centre = SegmentNormal::eye();
  const double mean = s.others / s.weight;
  centre(0, 4) = -mean;
  centre(2, 4) = mean * contrast;
  s.normal = centre.t() * s.normal * centre;
  s.right = centre.t() * s.right;
  s.widening = centre.t() * s.widening;
}

Segments measure_segments(std::span<const LinePoint> points, const EquatorLine& line, const Cuts& cuts,
                          double blur) {
  Segments result;
  const double far = cuts.far();
  for (Sums& s : sum_segments(points, line, cuts, blur)) {
    if (s.count < 20.0 || s.information <= 0.0) continue;
    for (int a = 0; a < 5; ++a)
      for (int b = 0; b < a; ++b) s.normal(b, a) = s.normal(a, b);
    centre_others(s, line.contrast);
    // Weak priors of the gradient, which is degenerate with the shift where one flank is hidden, and of the
    // neighbours' light, which is degenerate where it is even.
    s.normal(1, 1) += 0.02 * s.weight * far * far;
    s.normal(4, 4) += 0.002 * s.weight;
    bool solved = false;
    const SegmentNormal inverse = s.normal.inv(cv::DECOMP_CHOLESKY, &solved);
    if (!solved) continue;
    const SegmentTerms fit = inverse * s.right;
    Segment segment;
    segment.along = s.along / s.information;
    segment.contrast = fit[2];
    segment.contrast_sd = std::sqrt(inverse(2, 2));
    segment.widening = (inverse * s.widening)[3];
    result.segments.push_back(segment);
    result.shift.push_back(fit[3]);
    result.shift_variance.push_back(inverse(3, 3));
    result.residual += std::max(0.0, s.square - fit.dot(s.right));
    result.degrees_of_freedom += std::max(0.0, s.count - 5.0);
  }
  return result;
}

/// Angle, offset, tilt; what the line is wider, the ball farther along the line and larger than was assumed.
using LineTerms = cv::Vec<double, 6>;
using LineNormal = cv::Matx<double, 6, 6>;

/// Robust regression of the segments' offsets on the line's terms: Tukey's biweight, with priors of all but
/// the angle.
class Regression {
 public:
  Regression(LineFit& fit, const LineFitSettings& settings)
      : fit_(fit),
        settings_(settings),
        cos_tilt_(std::cos(fit.line.tilt_rad)),
        tan_tilt_(std::tan(fit.line.tilt_rad)) {
    for (Segment& segment : fit_.segments) {
      raw_.push_back(segment.offset);
      segment.inlier_weight = 1.0;
    }
  }

  /// Updates the line and its statistics. Returns false if it is not determined.
  bool run() {
    LineTerms change;
    for (int round = 0; round < kMaxRounds; ++round) {
      const double variance = scale_ > 0.0 ? scale_ * scale_ : fit_.expected_scatter;
      if (!solve(variance, change)) return false;
      for (std::size_t k = 0; k < raw_.size(); ++k)
        fit_.segments[k].offset = raw_[k] - row(fit_.segments[k]).dot(change);
      if (round < kScaleRounds) update_scale();
      for (Segment& s : fit_.segments) {
        const double t = std::abs(s.offset) * std::sqrt(s.weight) / (kBiweightReach_sd * scale_);
        s.inlier_weight = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
      }
    }
    set_statistics();
    if (!set_variance()) return false;
    fit_.line.angle_rad += change[0];
    fit_.line.offset += change[1];
    const double most = settings_.most_tilt_rad;
    fit_.line.tilt_rad = std::clamp(fit_.line.tilt_rad + change[2], -most, most);
    return true;
  }

 private:
  static constexpr int kMaxRounds = 12;
  static constexpr int kScaleRounds = 6;
  static constexpr double kParameters = 2.5;  // the priors take half of one

  LineTerms row(const Segment& s) const {
    const double middle = std::sqrt(std::max(0.04, 1.0 - s.along * s.along)), steep = tan_tilt_ / middle;
    return {s.along * cos_tilt_, 1.0, middle, s.widening, s.along * steep, steep};
  }

  /// Weights of the priors against offsets times weight of that variance.
  LineTerms priors(double variance) const {
    const auto weight = [&](double sd) { return variance / (sd * sd); };
    return {0.0,
            weight(std::hypot(settings_.offset_sd, settings_.centre_sd * tan_tilt_)),
            weight(settings_.tilt_sd),
            weight(ShapeGrid::kHalfWidthSd * fit_.line.shape.half_width),
            weight(std::max(settings_.centre_sd, 1e-5)),
            weight(std::max(settings_.radius_sd, 1e-5))};
  }

  bool solve(double variance, LineTerms& change) {
    LineNormal normal;
    LineTerms right;
    for (std::size_t k = 0; k < raw_.size(); ++k) {
      const Segment& s = fit_.segments[k];
      const LineTerms x = row(s);
      const double w = s.weight * s.inlier_weight;
      right += x * (w * raw_[k]);
      normal += (x * x.t()) * w;
    }
    const LineTerms prior = priors(variance);
    normal += LineNormal::diag(prior);
    right[1] += prior[1] * (settings_.offset - fit_.line.offset);
    right[2] -= prior[2] * fit_.line.tilt_rad;
    bool solved = false;
    const LineNormal inverse = normal.inv(cv::DECOMP_CHOLESKY, &solved);
    if (solved) change = inverse * right;
    return solved;
  }

  /// Median absolute residual, corrected for the fitted parameters.
  void update_scale() {
    std::vector<double> size;
    for (const Segment& s : fit_.segments) size.push_back(std::abs(s.offset) * std::sqrt(s.weight));
    const double n = static_cast<double>(size.size());
    scale_ = kSdOverMad * upper_median(std::move(size)) * std::sqrt(n / std::max(1.0, n - kParameters));
    scale_ = std::max(scale_, 0.5 * std::sqrt(fit_.expected_scatter));
  }

  /// Huber's variance of an M-estimate: mean psi² over the square of mean psi'.
  void set_statistics() {
    double psi2 = 0.0, slope = 0.0, products = 0.0, weights = 0.0, inliers = 0.0, square = 0.0;
    for (std::size_t k = 0; k < fit_.segments.size(); ++k) {
      const Segment& s = fit_.segments[k];
      const double r = s.offset * std::sqrt(s.weight), t = r / (kBiweightReach_sd * scale_);
      psi2 += r * r * s.inlier_weight * s.inlier_weight;
      if (t * t < 1.0) slope += (1.0 - t * t) * (1.0 - 5.0 * t * t);
      weights += s.weight;
      inliers += s.weight * s.inlier_weight;
      square += s.weight * s.offset * s.offset;
      if (k == 0) continue;
      const Segment& before = fit_.segments[k - 1];
      products += r * s.inlier_weight * before.offset * std::sqrt(before.weight) * before.inlier_weight;
    }
    const double n = static_cast<double>(fit_.segments.size());
    fit_.degrees_of_freedom = std::max(1.0, n - kParameters);
    const double mean_slope = std::max(0.2, slope / n), slope2 = mean_slope * mean_slope;
    mean_slope2_ = slope2;
    fit_.scatter = psi2 / fit_.degrees_of_freedom / slope2;
    // The fitted parameters make residuals of independent neighbours negatively correlated.
    fit_.covariance = (products + (n - fit_.degrees_of_freedom) * psi2 / fit_.degrees_of_freedom) /
                      fit_.degrees_of_freedom / slope2;
    fit_.inlier_fraction = weights > 0.0 ? inliers / weights : 0.0;
    fit_.rms_offset = weights > 0.0 ? std::sqrt(square / weights) : 0.0;
  }

  /// With full weights, as mean psi' accounts for the outliers. Returns false if the line is not determined.
  bool set_variance() {
    LineNormal normal;
    for (const Segment& s : fit_.segments) {
      const LineTerms x = row(s);
      normal += (x * x.t()) * s.weight;
    }
    const LineTerms prior = priors(fit_.scatter);
    normal += LineNormal::diag(prior);
    bool solved = false;
    const LineNormal inverse = normal.inv(cv::DECOMP_CHOLESKY, &solved);
    fit_.variance = inverse.get_minor<3, 3>(0, 0);
    fit_.prior = cv::Matx33d::diag({prior[0], prior[1], prior[2]});
    fit_.angle_variance = angle_variance(inverse, prior);
    return solved && fit_.variance(0, 0) > 0.0;
  }

  /// A seam or another ball's edge moves one stretch of the line: the sandwich estimator, with Bartlett's
  /// window along the line (Newey and West 1987).
  double angle_variance(const LineNormal& inverse, const LineTerms& prior) const {
    constexpr std::size_t kShared = 4;  // segments: a logo reaches over a few, as at outlines
    std::vector<double> pulls;
    for (const Segment& s : fit_.segments) {
      const LineTerms x = row(s), moved = inverse * x;
      // Corrects the residual for its own leverage.
      const double leverage = std::min(0.7, s.weight * x.dot(moved));
      pulls.push_back(moved[0] * s.weight * s.inlier_weight * s.offset / (1.0 - leverage));
    }
    double sum = 0.0, by_priors = 0.0;
    for (std::size_t k = 0; k < pulls.size(); ++k) {
      for (std::size_t lag = 0; lag < kShared && lag <= k; ++lag)
        sum += (lag == 0 ? 1.0 : 2.0 - 2.0 * static_cast<double>(lag) / kShared) * pulls[k] * pulls[k - lag];
    }
    for (int a = 0; a < 6; ++a) by_priors += inverse(0, a) * inverse(0, a) * prior[a] * fit_.scatter;
    return std::max(0.0, sum / mean_slope2_) + by_priors;
  }

  LineFit& fit_;
  const LineFitSettings& settings_;
  double cos_tilt_, tan_tilt_, mean_slope2_ = 1.0;
  std::vector<double> raw_;  ///< offsets from the line before the fit
  double scale_ = 0.0;
};

void set_contrast_statistics(LineFit& fit) {
  double first = 1.0, last = -1.0;
  std::vector<double> contrasts;
  for (const Segment& s : fit.segments) {
    // One that cannot distinguish half the line's contrast from none is not counted.
    if (s.contrast_sd * std::sqrt(fit.expected_scatter) > 0.5 * fit.line.contrast) continue;
    contrasts.push_back(s.contrast);
    first = std::min(first, s.along);
    last = std::max(last, s.along);
  }
  fit.span = std::max(0.0, last - first);
  if (contrasts.size() < 3) return;
  const double n = static_cast<double>(contrasts.size());
  const auto dark = std::ranges::count_if(contrasts, [&](double c) { return c > 0.4 * fit.line.contrast; });
  fit.dark_fraction = static_cast<double>(dark) / n;
  const double typical = upper_median(contrasts);
  for (double& c : contrasts) c = std::abs(c - typical);
  fit.contrast_significance =
      typical * std::sqrt(n) / (kSdOverMad * kSdOfMedian * upper_median(std::move(contrasts)) + 1e-6);
}

/// Returns false if there is no dark line.
bool set_contrast_and_offsets(Segments measured, LineFit& fit) {
  std::vector<std::pair<double, double>> contrasts;
  for (const Segment& s : measured.segments)
    contrasts.emplace_back(s.contrast, 1.0 / (s.contrast_sd * s.contrast_sd));
  fit.line.contrast = weighted_median(std::move(contrasts));
  if (!(fit.line.contrast > 1e-3)) return false;
  fit.expected_scatter = measured.residual / std::max(1.0, measured.degrees_of_freedom);
  fit.segments = std::move(measured.segments);
  for (std::size_t k = 0; k < fit.segments.size(); ++k) {
    // Linearized: beyond its own width a shift cannot be measured.
    const double most = fit.line.shape.half_width + fit.line.shape.soft;
    fit.segments[k].offset = std::clamp(measured.shift[k] / fit.line.contrast, -most, most);
    fit.segments[k].weight = fit.line.contrast * fit.line.contrast / measured.shift_variance[k];
  }
  return true;
}

}  // namespace

std::optional<LineFit> fit_line(std::span<const LinePoint> points, double radius, const EquatorLine& start,
                                const LineFitSettings& settings) {
  LineFit fit;
  fit.line = start;
  for (int round = 0; round < kRounds; ++round) {
    if (settings.shapes != nullptr && round < 2) {
      LineProfile profile;
      profile.add(points, fit.line);
      fit.line.shape = settings.shapes->best(profile);
    }
    Segments measured = measure_segments(points, fit.line, Cuts(fit.line, radius), settings.blur);
    if (measured.segments.size() < 5) return std::nullopt;
    if (!set_contrast_and_offsets(std::move(measured), fit)) return std::nullopt;
    if (!Regression(fit, settings).run()) return std::nullopt;
  }
  set_contrast_statistics(fit);
  return fit;
}

}  // namespace strobe::digitize
