#include "host/digitize/equator/line_fit.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kInner = 0.95;
constexpr int kMaxStretches = 24;
constexpr double kMinStretch_px = 5.0;
constexpr int kRounds = 3;
constexpr double kWithin = 0.22;  ///< to either side of a line is looked at, radii
constexpr double kRoom = 0.04;    ///< more, for a line that moves while it is fitted

/// Least squares of one stretch: level, gradient, darkness, shift.
struct Sums {
  cv::Matx44d normal;
  cv::Vec4d right;
  double square = 0.0;
  double along = 0.0;
  double weight = 0.0;
  double count = 0.0;
  double information = 0.0;  ///< weight of what is on the line's flanks
};

struct Measured4 {
  std::vector<Segment> segments;
  std::vector<double> shift;           ///< times contrast
  std::vector<double> shift_variance;  ///< but for the factor
  double rest = 0.0;                   ///< of squares within
  double freedom = 0.0;
};

void add(Sums& s, const LinePoint& point, double along, double f, double dark, double slope,
         double contrast) {
  const double w = point.weight;
  // What shading and felt leave is in proportion to the light, also on the line.
  const double lit = 1.0 - contrast * dark;
  const double level = w * lit, gradient = level * f, x = point.x;
  s.normal(0, 0) += level * lit;
  s.normal(1, 0) += gradient * lit;
  s.normal(1, 1) += gradient * f * lit;
  s.right[0] += level * x;
  s.right[1] += gradient * x;
  s.square += w * x * x;
  s.weight += w;
  s.count += 1.0;
  if (dark == 0.0) return;
  s.normal(2, 0) -= level * dark;
  s.normal(2, 1) -= gradient * dark;
  s.normal(2, 2) += w * dark * dark;
  s.normal(3, 0) += level * slope;
  s.normal(3, 1) += gradient * slope;
  s.normal(3, 2) -= w * dark * slope;
  const double tells = w * slope * slope;
  s.normal(3, 3) += tells;
  s.right[2] -= w * dark * x;
  s.right[3] += w * slope * x;
  s.along += tells * along;
  s.information += tells;
}

Measured4 measure_stretches(std::span<const LinePoint> points, const EquatorLine& line,
                            const ShapeTable& shape, int segments) {
  std::vector<Sums> sums(static_cast<std::size_t>(segments));
  const LineCoordinates place(line);
  const double within = 1.7 * shape.reach() + 0.02;
  for (const LinePoint& point : points) {
    const double f = place.across(point.u, point.v, point.z);
    if (std::abs(f) > within) continue;
    const double along = place.along(point.u, point.v);
    const int which = static_cast<int>((along / kInner + 1.0) * 0.5 * segments);
    if (which < 0 || which >= segments) continue;
    const auto [dark, slope] = shape.at(f);
    add(sums[static_cast<std::size_t>(which)], point, along, f, dark, slope, line.contrast);
  }
  Measured4 result;
  for (Sums& s : sums) {
    if (s.count < 20.0 || s.information <= 0.0) continue;
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b) s.normal(b, a) = s.normal(a, b);
    // What hides a flank leaves its shift to the gradient; a weak prior for the latter keeps it finite.
    s.normal(1, 1) += 0.02 * s.weight * within * within;
    bool solved = false;
    const cv::Matx44d inverse = s.normal.inv(cv::DECOMP_CHOLESKY, &solved);
    if (!solved) continue;
    const cv::Vec4d fit = inverse * s.right;
    Segment stretch;
    stretch.along = s.along / s.information;
    stretch.dark = fit[2];
    stretch.dark_sd = std::sqrt(inverse(2, 2));
    result.segments.push_back(stretch);
    result.shift.push_back(fit[3]);
    result.shift_variance.push_back(inverse(3, 3));
    const double mean_weight = s.weight / s.count;
    result.rest += std::max(0.0, s.square - fit.dot(s.right)) / mean_weight * mean_weight;
    result.freedom += std::max(0.0, s.count - 4.0);
  }
  return result;
}

double weighted_median(std::vector<std::pair<double, double>> values) {
  std::ranges::sort(values);
  double total = 0.0;
  for (const auto& [value, weight] : values) total += weight;
  double sum = 0.0;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= 0.5 * total) return value;
  }
  return 0.0;
}

/// Turn, shift and tilt that the segments ask for.
struct Step {
  cv::Vec3d change;
  double per_variance = 0.0;
};

/// Tukey's biweight, with priors for the shift and the tilt.
Step regress(LineFit& fit, const LineFitSettings& settings) {
  constexpr double kTukey = 4.685;
  Step step;
  auto& segments = fit.segments;
  const double cos_tilt = std::cos(fit.line.tilt_rad);
  std::vector<double> raw;
  for (const Segment& stretch : segments) raw.push_back(stretch.off);
  const auto row = [&](const Segment& s) {
    return cv::Vec3d(s.along * cos_tilt, 1.0, std::sqrt(std::max(0.0, 1.0 - s.along * s.along)) * cos_tilt);
  };
  for (Segment& stretch : segments) stretch.inlier_weight = 1.0;
  double scale = 0.0;
  for (int round = 0; round < 12; ++round) {
    cv::Matx33d normal;
    cv::Vec3d right;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const cv::Vec3d x = row(segments[k]);
      const double w = segments[k].weight * (round == 0 ? 1.0 : segments[k].inlier_weight);
      right += x * (w * raw[k]);
      normal += (x * x.t()) * w;
    }
    // The priors weigh by the scatter, which is one of squares times weight.
    const double variance = scale > 0.0 ? scale * scale : fit.inside_scatter;
    normal(1, 1) += variance / (settings.offset_sd * settings.offset_sd);
    right[1] -= variance / (settings.offset_sd * settings.offset_sd) * fit.line.offset;
    normal(2, 2) += variance / (settings.tilt_sd * settings.tilt_sd);
    right[2] -= variance / (settings.tilt_sd * settings.tilt_sd) * fit.line.tilt_rad;
    bool solved = false;
    const cv::Matx33d inverse = normal.inv(cv::DECOMP_CHOLESKY, &solved);
    if (!solved) return {};
    step.change = inverse * right;
    step.per_variance = inverse(0, 0);
    std::vector<double> size;
    for (std::size_t k = 0; k < segments.size(); ++k) {
      segments[k].off = raw[k] - row(segments[k]).dot(step.change);
      size.push_back(std::abs(segments[k].off) * std::sqrt(segments[k].weight));
    }
    if (round < 6) {
      std::ranges::sort(size);
      // Three parameters were fitted: the median of what is left would be too small.
      const double n = static_cast<double>(size.size());
      scale = 1.4826 * size[size.size() / 2] * std::sqrt(n / std::max(1.0, n - 2.5));
      scale = std::max(scale, 0.5 * std::sqrt(fit.inside_scatter));
    }
    for (std::size_t k = 0; k < segments.size(); ++k) {
      const double t = std::abs(segments[k].off) * std::sqrt(segments[k].weight) / (kTukey * scale);
      segments[k].inlier_weight = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
    }
  }
  // Huber's variance of an M-estimate: mean psi² over the square of mean psi'.
  double psi2 = 0.0, slope = 0.0, products = 0.0, weights = 0.0, inlier_weight = 0.0, square = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const auto& s = segments[k];
    const double r = s.off * std::sqrt(s.weight), t = r / (kTukey * scale);
    psi2 += r * r * s.inlier_weight * s.inlier_weight;
    if (t * t < 1.0) slope += (1.0 - t * t) * (1.0 - 5.0 * t * t);
    weights += s.weight;
    inlier_weight += s.weight * s.inlier_weight;
    square += s.weight * s.off * s.off;
    if (k > 0) {
      const auto& p = segments[k - 1];
      products += r * s.inlier_weight * p.off * std::sqrt(p.weight) * p.inlier_weight;
    }
  }
  const double n = static_cast<double>(segments.size());
  fit.freedom = std::max(1.0, n - 2.5);
  const double mean_slope = std::max(0.2, slope / n);
  fit.scatter = psi2 / fit.freedom / (mean_slope * mean_slope);
  // What is fitted makes next ones of independent segments differ: by its share, taken off again.
  fit.neighbours =
      (products + (n - fit.freedom) * psi2 / fit.freedom) / fit.freedom / (mean_slope * mean_slope);
  fit.inlier_share = weights > 0.0 ? inlier_weight / weights : 0.0;
  fit.rms_offset = weights > 0.0 ? std::sqrt(square / weights) : 0.0;
  // With all weights: the loss of the outliers' is in mean psi'.
  cv::Matx33d normal;
  for (const Segment& s : segments) {
    const cv::Vec3d x = row(s);
    normal += (x * x.t()) * s.weight;
  }
  normal(1, 1) += fit.scatter / (settings.offset_sd * settings.offset_sd);
  normal(2, 2) += fit.scatter / (settings.tilt_sd * settings.tilt_sd);
  bool solved = false;
  const cv::Matx33d inverse = normal.inv(cv::DECOMP_CHOLESKY, &solved);
  if (solved) step.per_variance = inverse(0, 0);
  return step;
}

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

void judge(LineFit& fit) {
  double first = 1.0, last = -1.0;
  std::vector<double> dark;
  for (const Segment& s : fit.segments) {
    // One that cannot tell half the line's contrast from none says nothing.
    if (s.dark_sd * std::sqrt(fit.inside_scatter) > 0.5 * fit.line.contrast) continue;
    dark.push_back(s.dark);
    first = std::min(first, s.along);
    last = std::max(last, s.along);
  }
  fit.span = std::max(0.0, last - first);
  if (dark.size() < 3) return;
  const double n = static_cast<double>(dark.size());
  fit.dark_share = static_cast<double>(
                       std::ranges::count_if(dark, [&](double d) { return d > 0.4 * fit.line.contrast; })) /
                   n;
  const double usual = middle_of(dark);
  for (double& d : dark) d = std::abs(d - usual);
  fit.contrast_significance = usual * std::sqrt(n) / (1.4826 * 1.2533 * middle_of(dark) + 1e-6);
}

}  // namespace

std::vector<LinePoint> points_near(BallPixels& rows, const EquatorLine& line) {
  std::vector<LinePoint> points;
  const LineCoordinates place(line);
  const double within = kWithin + kRoom;
  const BallPixels::Band band{line.angle_rad,
                              within + std::abs(std::sin(line.tilt_rad)) + std::abs(line.offset)};
  const float floor2 = rows.floor() * rows.floor();
  const cv::Range range = rows.rows(kInner);
  for (int j = range.start; j < range.end; ++j) {
    for (const BallPixels::Block& block : rows.row(j, kInner, band)) {
      if (!block.use || block.own <= rows.floor()) continue;
      if (std::abs(place.across(block.u, block.v, block.z)) > within) continue;
      points.push_back({block.u, block.v, block.z, block.left / block.own,
                        block.own * block.own / (block.noise + floor2)});
    }
  }
  return points;
}

namespace {
double bin_middle(int bin) { return kWithin * (2.0 * (bin + 0.5) / LineProfile::kBins - 1.0); }
}  // namespace

void LineProfile::add(std::span<const LinePoint> points, const EquatorLine& line) {
  const LineCoordinates place(line);
  for (const LinePoint& point : points) {
    const double f = place.across(point.u, point.v, point.z);
    const double bin = (f / kWithin + 1.0) * 0.5 * kBins;
    if (!(bin >= 0.0 && bin < kBins)) continue;
    const auto at = static_cast<std::size_t>(bin);
    sum[at] += static_cast<double>(point.weight) * point.x;
    weight[at] += point.weight;
  }
}

void LineProfile::add(const LineProfile& other) {
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    sum[bin] += other.sum[bin];
    weight[bin] += other.weight[bin];
  }
}

ShapeGrid::ShapeGrid(double radius) {
  const double softest = std::max(0.004, 0.5 / radius);
  for (double half = 0.012; half < 0.13; half *= 1.25) {
    for (double soft = softest; soft < 0.05; soft *= 1.7) {
      const LineShape shape{half, soft};
      if (shape.reach() > 0.8 * kWithin) continue;
      Trial& trial = trials_.emplace_back(Trial{shape, {}});
      for (int bin = 0; bin < LineProfile::kBins; ++bin)
        trial.darkness[static_cast<std::size_t>(bin)] = shape.darkness(bin_middle(bin));
    }
  }
}

LineShape ShapeGrid::best(const LineProfile& profile) const {
  LineShape best;
  double least = 1e300;
  for (const Trial& trial : trials_) {
    // A level and a bow of the ground go with the line.
    cv::Matx33d normal = cv::Matx33d::eye() * 1e-9;
    cv::Vec3d right;
    double square = 0.0;
    for (std::size_t bin = 0; bin < LineProfile::kBins; ++bin) {
      const double w = profile.weight[bin];
      if (w <= 0.0) continue;
      const double f = bin_middle(static_cast<int>(bin)), sum = profile.sum[bin];
      const cv::Vec3d row(1.0, f * f, trial.darkness[bin]);
      for (int a = 0; a < 3; ++a) {
        right[a] += row[a] * sum;
        for (int b = 0; b < 3; ++b) normal(a, b) += w * row[a] * row[b];
      }
      square += sum * sum / w;
    }
    const cv::Vec3d fit = normal.solve(right, cv::DECOMP_CHOLESKY);
    const double rest = square - fit.dot(right);
    if (fit[2] < 0.0 && rest < least) {
      least = rest;
      best = trial.shape;
    }
  }
  return best;
}

std::optional<LineFit> fit_line(std::span<const LinePoint> points, double radius, const EquatorLine& start,
                                const LineFitSettings& settings) {
  LineFit fit;
  fit.line = start;
  const int segments = std::clamp(static_cast<int>(2.0 * kInner * radius / kMinStretch_px), 6, kMaxStretches);
  for (int round = 0; round < kRounds; ++round) {
    if (settings.shapes != nullptr && round < 2) {
      LineProfile profile;
      profile.add(points, fit.line);
      fit.line.shape = settings.shapes->best(profile);
    }
    const ShapeTable shape(fit.line.shape);
    Measured4 measured = measure_stretches(points, fit.line, shape, segments);
    if (measured.segments.size() < 5) return std::nullopt;
    std::vector<std::pair<double, double>> darks;
    for (const Segment& s : measured.segments) darks.emplace_back(s.dark, 1.0 / (s.dark_sd * s.dark_sd));
    fit.line.contrast = weighted_median(darks);
    if (!(fit.line.contrast > 1e-3)) return std::nullopt;
    fit.inside_scatter = measured.rest / std::max(1.0, measured.freedom);
    fit.segments = std::move(measured.segments);
    for (std::size_t k = 0; k < fit.segments.size(); ++k) {
      // Far off, the slope no longer says how far: no more than its width can be told.
      const double most = fit.line.shape.half_width + fit.line.shape.soft;
      fit.segments[k].off = std::clamp(measured.shift[k] / fit.line.contrast, -most, most);
      fit.segments[k].weight = fit.line.contrast * fit.line.contrast / measured.shift_variance[k];
    }
    const Step step = regress(fit, settings);
    if (!(step.per_variance > 0.0)) return std::nullopt;
    fit.per_variance = step.per_variance;
    fit.line.angle_rad += step.change[0];
    fit.line.offset += step.change[1];
    fit.line.tilt_rad = std::clamp(fit.line.tilt_rad + step.change[2], -0.45, 0.45);
  }
  judge(fit);
  return fit;
}

}  // namespace strobe::digitize
