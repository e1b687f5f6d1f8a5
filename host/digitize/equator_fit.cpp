#include "host/digitize/equator_fit.hpp"

#include <algorithm>
#include <array>
#include <numbers>

namespace strobe::digitize {
namespace {

constexpr double kInner = 0.95;
constexpr int kMostStretches = 24;
constexpr double kLeastStretch_px = 5.0;
constexpr int kRounds = 3;
constexpr double kWithin = 0.22;  ///< to either side of a line is looked at, radii

/// A block near the line: brightness relative to the ball's own.
struct Point {
  double u = 0.0, v = 0.0;
  double x = 0.0;
  double weight = 0.0;
};

std::vector<Point> gather(const Blocks& blocks, const Flattened& flattened, const Disc& disc,
                          const Shading& shading, const DiscLine& line, double within) {
  std::vector<Point> points;
  const cv::Rect box = blocks.around(disc, kInner);
  const LinePlace place(line);
  const float middle = std::max(1e-6F, shading.at(0.0F, 0.0F, 1.0F));
  const float floor = 0.05F * middle;
  for (int j = box.y; j < box.y + box.height; ++j) {
    const float* left = flattened.left.ptr<float>(j);
    const float* noise = flattened.noise.ptr<float>(j);
    for (int i = box.x; i < box.x + box.width; ++i) {
      if (noise[i] < 0.0F) continue;
      const cv::Point2d unit = disc.unit(blocks.column(i), blocks.row(j));
      const double r = unit.dot(unit);
      if (r > kInner * kInner || std::abs(place.across(unit.x, unit.y)) > within) continue;
      const float own = shading.at(static_cast<float>(unit.x), static_cast<float>(unit.y),
                                   static_cast<float>(std::sqrt(1.0 - r)));
      if (own <= floor) continue;
      points.push_back({unit.x, unit.y, left[i] / own, own * own / (noise[i] + floor * floor)});
    }
  }
  return points;
}

/// Weighted means of the brightness across the line.
struct Profile {
  static constexpr int kBins = 81;
  std::array<double, kBins> sum{};
  std::array<double, kBins> weight{};

  double at(int bin) const { return kWithin * (2.0 * (bin + 0.5) / kBins - 1.0); }
  void add(double f, double x, double w) {
    const int bin = static_cast<int>((f / kWithin + 1.0) * 0.5 * kBins);
    if (bin < 0 || bin >= kBins) return;
    sum[static_cast<std::size_t>(bin)] += w * x;
    weight[static_cast<std::size_t>(bin)] += w;
  }
};

/// The shape of least squares, by trial; a level and a bow of the ground go with it.
LineShape fit_shape(const Profile& profile, double softest) {
  LineShape best;
  double least = 1e300;
  for (double half = 0.012; half < 0.13; half *= 1.25) {
    for (double soft = softest; soft < 0.05; soft *= 1.7) {
      const LineShape shape{half, soft};
      if (shape.reach() > 0.8 * kWithin) continue;
      cv::Matx33d normal = cv::Matx33d::eye() * 1e-9;
      cv::Vec3d right;
      double square = 0.0;
      for (int bin = 0; bin < Profile::kBins; ++bin) {
        const double w = profile.weight[static_cast<std::size_t>(bin)];
        if (w <= 0.0) continue;
        const double f = profile.at(bin), x = profile.sum[static_cast<std::size_t>(bin)] / w;
        const cv::Vec3d row(1.0, f * f, shape.darkness(f));
        for (int a = 0; a < 3; ++a) {
          right[a] += w * row[a] * x;
          for (int b = 0; b < 3; ++b) normal(a, b) += w * row[a] * row[b];
        }
        square += w * x * x;
      }
      const cv::Vec3d fit = normal.solve(right, cv::DECOMP_CHOLESKY);
      const double rest = square - fit.dot(right);
      if (fit[2] < 0.0 && rest < least) {
        least = rest;
        best = shape;
      }
    }
  }
  return best;
}

/// The darkness of a shape and its slope, looked up.
class ShapeTable {
 public:
  explicit ShapeTable(const LineShape& shape) : reach_(shape.reach()) {
    for (int k = 0; k <= kSteps; ++k) {
      const double f = reach_ * k / kSteps;
      dark_[static_cast<std::size_t>(k)] = shape.darkness(f);
      slope_[static_cast<std::size_t>(k)] = shape.slope(f);
    }
  }
  double reach() const { return reach_; }
  /// Darkness and slope.
  std::pair<double, double> at(double f) const {
    const double place = std::abs(f) / reach_ * kSteps;
    if (place >= kSteps) return {0.0, 0.0};
    const auto k = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(k);
    const double dark = dark_[k] + part * (dark_[k + 1] - dark_[k]);
    const double slope = slope_[k] + part * (slope_[k + 1] - slope_[k]);
    return {dark, f < 0.0 ? -slope : slope};
  }

 private:
  static constexpr int kSteps = 200;
  double reach_;
  std::array<double, kSteps + 1> dark_{};
  std::array<double, kSteps + 1> slope_{};
};

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
  std::vector<Stretch> stretches;
  std::vector<double> shift;           ///< times contrast
  std::vector<double> shift_variance;  ///< but for the factor
  double rest = 0.0;                   ///< of squares within
  double freedom = 0.0;
};

Measured4 measure_stretches(const std::vector<Point>& points, const DiscLine& line, const ShapeTable& shape,
                            int stretches) {
  std::vector<Sums> sums(static_cast<std::size_t>(stretches));
  const LinePlace place(line);
  const double within = 1.7 * shape.reach() + 0.02;
  for (const Point& point : points) {
    const double f = place.across(point.u, point.v);
    if (std::abs(f) > within) continue;
    const double along = place.along(point.u, point.v);
    const int which = static_cast<int>((along / kInner + 1.0) * 0.5 * stretches);
    if (which < 0 || which >= stretches) continue;
    const auto [dark, slope] = shape.at(f);
    // What shading and felt leave is in proportion to the light, also on the line.
    const double lit = 1.0 - line.contrast * dark;
    const cv::Vec4d row(lit, f * lit, -dark, slope);
    Sums& s = sums[static_cast<std::size_t>(which)];
    for (int a = 0; a < 4; ++a) {
      s.right[a] += point.weight * row[a] * point.x;
      for (int b = 0; b <= a; ++b) s.normal(a, b) += point.weight * row[a] * row[b];
    }
    s.square += point.weight * point.x * point.x;
    const double tells = point.weight * slope * slope;
    s.along += tells * along;
    s.information += tells;
    s.weight += point.weight;
    s.count += 1.0;
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
    Stretch stretch;
    stretch.along = s.along / s.information;
    stretch.dark = fit[2];
    stretch.dark_sd = std::sqrt(inverse(2, 2));
    result.stretches.push_back(stretch);
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

/// Turn, shift and tilt that the stretches ask for.
struct Step {
  cv::Vec3d change;
  double per_variance = 0.0;
};

/// Tukey's biweight, with priors for the shift and the tilt.
Step regress(LineFit& fit, const FitSettings& settings) {
  constexpr double kTukey = 4.685;
  Step step;
  auto& stretches = fit.stretches;
  const double cos_tilt = std::cos(fit.line.tilt_rad);
  std::vector<double> raw;
  for (const Stretch& stretch : stretches) raw.push_back(stretch.off);
  const auto row = [&](const Stretch& s) {
    return cv::Vec3d(s.along * cos_tilt, 1.0, std::sqrt(std::max(0.0, 1.0 - s.along * s.along)) * cos_tilt);
  };
  for (Stretch& stretch : stretches) stretch.standing = 1.0;
  double scale = 0.0;
  for (int round = 0; round < 12; ++round) {
    cv::Matx33d normal;
    cv::Vec3d right;
    for (std::size_t k = 0; k < stretches.size(); ++k) {
      const cv::Vec3d x = row(stretches[k]);
      const double w = stretches[k].weight * (round == 0 ? 1.0 : stretches[k].standing);
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
    for (std::size_t k = 0; k < stretches.size(); ++k) {
      stretches[k].off = raw[k] - row(stretches[k]).dot(step.change);
      size.push_back(std::abs(stretches[k].off) * std::sqrt(stretches[k].weight));
    }
    if (round < 6) {
      std::ranges::sort(size);
      // Three parameters were fitted: the median of what is left would be too small.
      const double n = static_cast<double>(size.size());
      scale = 1.4826 * size[size.size() / 2] * std::sqrt(n / std::max(1.0, n - 2.5));
      scale = std::max(scale, 0.5 * std::sqrt(fit.inside_scatter));
    }
    for (std::size_t k = 0; k < stretches.size(); ++k) {
      const double t = std::abs(stretches[k].off) * std::sqrt(stretches[k].weight) / (kTukey * scale);
      stretches[k].standing = t < 1.0 ? (1.0 - t * t) * (1.0 - t * t) : 0.0;
    }
  }
  // Huber's variance of an M-estimate: mean psi² over the square of mean psi'.
  double psi2 = 0.0, slope = 0.0, products = 0.0, weights = 0.0, standing = 0.0;
  for (std::size_t k = 0; k < stretches.size(); ++k) {
    const auto& s = stretches[k];
    const double r = s.off * std::sqrt(s.weight), t = r / (kTukey * scale);
    psi2 += r * r * s.standing * s.standing;
    if (t * t < 1.0) slope += (1.0 - t * t) * (1.0 - 5.0 * t * t);
    weights += s.weight;
    standing += s.weight * s.standing;
    if (k > 0) {
      const auto& p = stretches[k - 1];
      products += r * s.standing * p.off * std::sqrt(p.weight) * p.standing;
    }
  }
  const double n = static_cast<double>(stretches.size());
  fit.freedom = std::max(1.0, n - 2.5);
  const double mean_slope = std::max(0.2, slope / n);
  fit.scatter = psi2 / fit.freedom / (mean_slope * mean_slope);
  fit.neighbours = products / fit.freedom / (mean_slope * mean_slope);
  fit.standing_share = weights > 0.0 ? standing / weights : 0.0;
  // With all weights: the loss of the outliers' is in mean psi'.
  cv::Matx33d normal;
  for (const Stretch& s : stretches) {
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
  for (const Stretch& s : fit.stretches) {
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
  fit.steadiness = usual * std::sqrt(n) / (1.4826 * 1.2533 * middle_of(dark) + 1e-6);
}

}  // namespace

std::optional<LineFit> fit_line(const Blocks& blocks, const Flattened& flattened, const Disc& disc,
                                const Shading& shading, const DiscLine& start, const FitSettings& settings) {
  LineFit fit;
  fit.line = start;
  const std::vector<Point> points = gather(blocks, flattened, disc, shading, start, kWithin + 0.04);
  const double radius = disc.radius_image_px / blocks.stride;
  const int stretches =
      std::clamp(static_cast<int>(2.0 * kInner * radius / kLeastStretch_px), 6, kMostStretches);
  for (int round = 0; round < kRounds; ++round) {
    if (!settings.shape_known && round < 2) {
      Profile profile;
      const LinePlace place(fit.line);
      for (const Point& point : points) profile.add(place.across(point.u, point.v), point.x, point.weight);
      fit.line.shape = fit_shape(profile, std::max(0.004, 0.5 / radius));
    }
    const ShapeTable shape(fit.line.shape);
    Measured4 measured = measure_stretches(points, fit.line, shape, stretches);
    if (measured.stretches.size() < 5) return std::nullopt;
    std::vector<std::pair<double, double>> darks;
    for (const Stretch& s : measured.stretches) darks.emplace_back(s.dark, 1.0 / (s.dark_sd * s.dark_sd));
    fit.line.contrast = weighted_median(darks);
    if (!(fit.line.contrast > 1e-3)) return std::nullopt;
    fit.inside_scatter = measured.rest / std::max(1.0, measured.freedom);
    fit.stretches = std::move(measured.stretches);
    for (std::size_t k = 0; k < fit.stretches.size(); ++k) {
      // Far off, the slope no longer says how far: no more than its width can be told.
      const double most = fit.line.shape.half_width + fit.line.shape.soft;
      fit.stretches[k].off = std::clamp(measured.shift[k] / fit.line.contrast, -most, most);
      fit.stretches[k].weight = fit.line.contrast * fit.line.contrast / measured.shift_variance[k];
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
