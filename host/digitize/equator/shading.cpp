#include "host/digitize/equator/shading.hpp"

#include <algorithm>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

double LineShape::darkness(double f) const {
  const double scale = 1.0 / (std::numbers::sqrt2 * soft);
  const double full = std::erf(half_width * scale);
  return 0.5 * (std::erf((f + half_width) * scale) - std::erf((f - half_width) * scale)) / full;
}

double LineShape::derivative(double f) const {
  const auto bell = [&](double x) { return std::exp(-0.5 * (x / soft) * (x / soft)); };
  const double full = std::erf(half_width / (std::numbers::sqrt2 * soft));
  return (bell(f + half_width) - bell(f - half_width)) / (std::sqrt(2.0 * std::numbers::pi) * soft * full);
}

ShapeTable::ShapeTable(const LineShape& shape)
    : reach_(shape.reach()), per_radius_(kSteps / std::max(1e-9, reach_)) {
  for (int k = 0; k <= kSteps; ++k) {
    const double f = reach_ * k / kSteps;
    dark_[static_cast<std::size_t>(k)] = shape.darkness(f);
    derivative_[static_cast<std::size_t>(k)] = shape.derivative(f);
  }
}

cv::Point2d Disc::half_extent_px(double radii) const {
  return {radii * std::hypot(image_from_unit(0, 0), image_from_unit(0, 1)),
          radii * std::hypot(image_from_unit(1, 0), image_from_unit(1, 1))};
}

Disc make_disc(const PlaneMap& map, const Outline& outline) {
  Disc disc;
  disc.centre_image = map.to_image(outline.centre);
  const EllipsePx ellipse = map.outline(outline.centre, outline.diameter);
  const double c = std::cos(ellipse.axis_rad), s = std::sin(ellipse.axis_rad);
  const cv::Matx22d turn(c, -s, s, c);
  disc.plane_from_unit = turn * cv::Matx22d(ellipse.along, 0.0, 0.0, ellipse.across) * turn.t();
  disc.unit_from_image = disc.plane_from_unit.inv() * map.jacobian(disc.centre_image);
  disc.image_from_unit = disc.unit_from_image.inv();
  disc.radius_image_px = std::sqrt(std::abs(cv::determinant(disc.image_from_unit)));
  // Two sd of the edge's blur to either side, and about a pixel of the felt's fuzz.
  const double disturbed_px = 2.0 * std::clamp(outline.blur_px, 0.5, 8.0) + 1.5;
  disc.rim = disturbed_px / disc.radius_image_px;
  disc.blur = outline.blur_px / (0.5 * outline.diameter);
  const double variance = 0.5 * (outline.covariance(0, 0) + outline.covariance(1, 1));
  disc.centre_sd = std::sqrt(std::max(0.0, variance)) / (0.5 * outline.diameter);
  disc.radius_sd = outline.diameter_sd() / outline.diameter;
  return disc;
}

bool is_valid(const Disc& disc) {
  return std::isfinite(disc.centre_image.x) && std::isfinite(disc.centre_image.y) &&
         std::isfinite(disc.radius_image_px) && disc.radius_image_px >= 1.0 && disc.radius_image_px <= 1e5 &&
         std::isfinite(disc.centre_sd);
}

namespace {

/// Closer to the outline, shading is too steep for low orders.
constexpr double kShadingInner = 0.96;
constexpr int kSweeps = 4;

/// One bin under one disc.
struct Sample {
  int point = 0;  ///< index of the bin
  std::array<float, Shading::kTerms> basis{};
};

struct Samples {
  std::vector<float> value;  ///< of each bin: intensity less background
  std::vector<std::vector<Sample>> of_disc;
};

/// What threads share: as many parts on every machine, so that sums are the same.
constexpr int kParts = 8;

cv::Range part_of(int count, int part) { return {count * part / kParts, count * (part + 1) / kParts}; }

/// Median intensity around a disc and outside of all others. Returns nullopt if hardly any of that is
/// visible.
std::optional<float> background_around(const BinnedImage& image, std::span<const Disc> discs,
                                       const Disc& disc) {
  std::vector<float> values;
  constexpr int kDirections = 72;
  for (const double radii : {1.1, 1.2, 1.3}) {
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * CV_PI * k / kDirections;
      const cv::Vec2d away =
          disc.image_from_unit * cv::Vec2d(radii * std::cos(angle), radii * std::sin(angle));
      const cv::Point2d at = disc.centre_image + cv::Point2d(away[0], away[1]);
      const int i = static_cast<int>(std::lround((at.x + 0.5 - image.origin.x) / image.stride - 0.5));
      const int j = static_cast<int>(std::lround((at.y + 0.5 - image.origin.y) / image.stride - 0.5));
      if (i < 0 || j < 0 || i >= image.intensity.cols || j >= image.intensity.rows) continue;
      const bool covered = std::ranges::any_of(discs, [&](const Disc& other) {
        const cv::Point2d unit = other.unit(at.x, at.y);
        return unit.dot(unit) < (1.0 + other.rim) * (1.0 + other.rim);
      });
      if (!covered) values.push_back(image.intensity.at<float>(j, i));
    }
  }
  if (values.size() < kDirections / 8) return std::nullopt;
  return upper_median(std::move(values));
}

std::vector<float> backgrounds(const BinnedImage& image, std::span<const Disc> discs) {
  std::vector<std::optional<float>> seen;
  std::vector<float> known;
  for (const Disc& disc : discs) {
    seen.push_back(background_around(image, discs, disc));
    if (seen.back()) known.push_back(*seen.back());
  }
  const float usual = upper_median(std::move(known));
  std::vector<float> result;
  for (const auto& one : seen) result.push_back(one.value_or(usual));
  return result;
}

/// A disc of a row's bins: those within `radii` lie from column `from` to column `to`.
struct NearDisc {
  std::size_t disc = 0;
  int from = 0, to = 0;
};

/// Discs near a row of bins.
void near_row(const BinnedImage& image, std::span<const Disc> discs, int row, double radii,
              std::vector<NearDisc>& near) {
  near.clear();
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const cv::Point2d half = discs[k].half_extent_px(radii);
    if (std::abs(image.row(row) - discs[k].centre_image.y) > half.y) continue;
    const auto column = [&](double px) { return (px + 0.5 - image.origin.x) / image.stride - 0.5; };
    near.push_back({k, static_cast<int>(std::floor(column(discs[k].centre_image.x - half.x))),
                    static_cast<int>(std::ceil(column(discs[k].centre_image.x + half.x)))});
  }
}

/// Every step-th bin of every step-th row of some.
void sample_rows(const BinnedImage& image, std::span<const Disc> discs, std::span<const Shading> shadings,
                 const cv::Range& rows, int step, Samples& samples) {
  samples.of_disc.resize(discs.size());
  std::vector<NearDisc> near;
  std::vector<std::pair<std::size_t, cv::Point2d>> over;
  for (int row = rows.start; row < rows.end; ++row) {
    const int j = row * step;
    near_row(image, discs, j, 1.1, near);
    if (near.empty()) continue;
    const float* intensity = image.intensity.ptr<float>(j);
    for (int i = 0; i < image.intensity.cols; i += step) {
      if (intensity[i] >= image.saturation) continue;
      over.clear();
      bool use = true;
      for (const auto& [k, from, to] : near) {
        if (i < from || i > to) continue;
        const cv::Point2d unit = discs[k].unit(image.column(i), image.row(j));
        const double r = unit.dot(unit);
        if (r > (1.0 + discs[k].rim) * (1.0 + discs[k].rim)) continue;
        use = use && r < kShadingInner * kShadingInner && r < (1.0 - discs[k].rim) * (1.0 - discs[k].rim);
        over.emplace_back(k, unit);
      }
      if (!use || over.empty()) continue;
      float background = 0.0F;
      for (const auto& [k, unit] : over) {
        Sample& sample = samples.of_disc[k].emplace_back();
        sample.point = static_cast<int>(samples.value.size());
        const auto u = static_cast<float>(unit.x), v = static_cast<float>(unit.y);
        Shading::basis(u, v, std::sqrt(std::max(0.0F, 1.0F - u * u - v * v)), sample.basis.data());
        background += shadings[k].background;
      }
      samples.value.push_back(intensity[i] - background / static_cast<float>(over.size()));
    }
  }
}

Samples take_samples(const BinnedImage& image, std::span<const Disc> discs, std::span<const Shading> shadings,
                     int across) {
  double radius = 0.0;
  for (const Disc& disc : discs) radius = std::max(radius, disc.radius_image_px);
  const int step = std::max(1, static_cast<int>(2.0 * radius / image.stride / across));
  const int rows = (image.intensity.rows + step - 1) / step;
  std::array<Samples, kParts> parts;
  cv::parallel_for_(cv::Range(0, kParts), [&](const cv::Range& range) {
    for (int part = range.start; part < range.end; ++part)
      sample_rows(image, discs, shadings, part_of(rows, part), step, parts[static_cast<std::size_t>(part)]);
  });
  Samples samples = std::move(parts.front());
  for (auto part = parts.begin() + 1; part != parts.end(); ++part) {
    const int before = static_cast<int>(samples.value.size());
    samples.value.insert(samples.value.end(), part->value.begin(), part->value.end());
    for (std::size_t k = 0; k < discs.size(); ++k) {
      for (Sample& sample : part->of_disc[k]) sample.point += before;
      samples.of_disc[k].insert(samples.of_disc[k].end(), part->of_disc[k].begin(), part->of_disc[k].end());
    }
  }
  return samples;
}

using Normal = cv::Matx<double, Shading::kTerms, Shading::kTerms>;
using Terms = cv::Vec<double, Shading::kTerms>;

/// The lower half.
void add(Normal& normal, const float* basis, double weight) {
  for (int a = 0; a < Shading::kTerms; ++a) {
    const double scaled = weight * basis[a];
    for (int b = 0; b <= a; ++b) normal(a, b) += scaled * basis[b];
  }
}

std::optional<Terms> solved(Normal normal, const Terms& right) {
  for (int a = 0; a < Shading::kTerms; ++a)
    for (int b = 0; b < a; ++b) normal(b, a) = normal(a, b);
  Terms x;
  if (!cv::solve(normal, right, x, cv::DECOMP_CHOLESKY)) return std::nullopt;
  return x;
}

/// Terms in single precision, which the basis has, too.
class FloatTerms {
 public:
  explicit FloatTerms(const Terms& terms) {
    for (int a = 0; a < Shading::kTerms; ++a)
      terms_[static_cast<std::size_t>(a)] = static_cast<float>(terms[a]);
  }
  double dot(const Sample& sample) const {
    cv::v_float32x4 sum = cv::v_setzero_f32();
    for (std::size_t a = 0; a < Shading::kTerms; a += kLanes)
      sum = cv::v_muladd(cv::v_load(&sample.basis[a]), cv::v_load(&terms_[a]), sum);
    return static_cast<double>(cv::v_reduce_sum(sum));
  }

 private:
  static constexpr std::size_t kLanes = 4;
  std::array<float, Shading::kTerms> terms_;
};

/// One shading for all discs, which regularizes those that overlap.
Terms common_terms(const Samples& samples) {
  std::vector<std::array<float, Shading::kTerms>> sums(samples.value.size());
  for (const auto& disc : samples.of_disc)
    for (const Sample& sample : disc)
      for (std::size_t a = 0; a < Shading::kTerms; ++a)
        sums[static_cast<std::size_t>(sample.point)][a] += sample.basis[a];
  std::array<Normal, kParts> normals{};
  std::array<Terms, kParts> rights{};
  cv::parallel_for_(cv::Range(0, kParts), [&](const cv::Range& range) {
    for (auto part = static_cast<std::size_t>(range.start); part < static_cast<std::size_t>(range.end);
         ++part) {
      const cv::Range points = part_of(static_cast<int>(sums.size()), static_cast<int>(part));
      for (auto p = static_cast<std::size_t>(points.start); p < static_cast<std::size_t>(points.end); ++p) {
        add(normals[part], sums[p].data(), 1.0);
        for (int a = 0; a < Shading::kTerms; ++a)
          rights[part][a] += samples.value[p] * sums[p][static_cast<std::size_t>(a)];
      }
    }
  });
  Normal normal = Normal::eye() * 1e-3;
  Terms right;
  for (std::size_t part = 0; part < kParts; ++part) normal += normals[part], right += rights[part];
  return solved(normal, right).value_or(Terms());
}

/// Huber's threshold: 1.5 robust sd, from the positive residuals only, as lines are dark.
double huber_limit(const std::vector<double>& left) {
  std::vector<double> bright;
  for (const double x : left)
    if (x > 0.0) bright.push_back(x);
  if (bright.size() <= 10) return 1e30;
  return 1.5 * kSdOverMad * upper_median(std::move(bright)) + 1e-9;
}

/// Of each disc's samples, with weight one.
std::vector<Normal> unweighted_normals(const Samples& samples) {
  std::vector<Normal> normals(samples.of_disc.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(normals.size())), [&](const cv::Range& range) {
    for (int k = range.start; k < range.end; ++k) {
      Normal& normal = normals[static_cast<std::size_t>(k)];
      for (const Sample& sample : samples.of_disc[static_cast<std::size_t>(k)])
        add(normal, sample.basis.data(), 1.0);
    }
  });
  return normals;
}

/// The factor of the common shading that comes closest to a ball's.
double scale_of(const Normal& lower, const Terms& common, const Terms& terms) {
  double both = 0.0, square = 0.0;
  for (int a = 0; a < Shading::kTerms; ++a) {
    for (int b = 0; b <= a; ++b) {
      const double n = lower(a, b);
      both += n * (common[a] * terms[b] + (a == b ? 0.0 : common[b] * terms[a]));
      square += n * common[a] * common[b] * (a == b ? 1.0 : 2.0);
    }
  }
  return square > 0.0 ? both / square : 1.0;
}

/// Each ball in turn to the residuals of the others (backfitting), with the scaled common shading as prior,
/// as lamps vary from flash to flash. Huber's weights from the second sweep on.
std::vector<Terms> own_terms(const Samples& samples, const Terms& common) {
  constexpr double kPriorSamples = 64.0;
  std::vector<Terms> terms(samples.of_disc.size(), common);
  const std::vector<Normal> unweighted = unweighted_normals(samples);
  std::vector<double> left(samples.value.begin(), samples.value.end());
  const FloatTerms by_common(common);
  for (const auto& disc : samples.of_disc)
    for (const Sample& sample : disc) left[static_cast<std::size_t>(sample.point)] -= by_common.dot(sample);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    const double limit = sweep > 0 ? huber_limit(left) : 1e30;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      // For the change of the terms; weights below one are subtracted from the unweighted equations.
      Normal normal = unweighted[k];
      Terms right = (common * scale_of(unweighted[k], common, terms[k]) - terms[k]) * kPriorSamples;
      for (const Sample& sample : samples.of_disc[k]) {
        double residual = left[static_cast<std::size_t>(sample.point)];
        const double size = std::abs(residual);
        if (size > limit) {
          add(normal, sample.basis.data(), limit / size - 1.0);
          residual *= limit / size;
        }
        for (int a = 0; a < Shading::kTerms; ++a)
          right[a] += residual * sample.basis[static_cast<std::size_t>(a)];
      }
      for (int a = 0; a < Shading::kTerms; ++a) normal(a, a) += kPriorSamples;
      const auto change = solved(normal, right);
      if (!change) continue;
      const FloatTerms by_change(*change);
      for (const Sample& sample : samples.of_disc[k])
        left[static_cast<std::size_t>(sample.point)] -= by_change.dot(sample);
      terms[k] += *change;
    }
  }
  return terms;
}

}  // namespace

cv::Rect BinnedImage::around(const Disc& disc, double radii) const {
  const cv::Point2d half = disc.half_extent_px(radii);
  const auto index = [&](double px, int start) { return (px + 0.5 - start) / stride - 0.5; };
  const int left = static_cast<int>(
      std::ceil(std::clamp(index(disc.centre_image.x - half.x, origin.x), 0.0, intensity.cols * 1.0)));
  const int right = static_cast<int>(
      std::floor(std::clamp(index(disc.centre_image.x + half.x, origin.x), -1.0, intensity.cols - 1.0)));
  const int top = static_cast<int>(
      std::ceil(std::clamp(index(disc.centre_image.y - half.y, origin.y), 0.0, intensity.rows * 1.0)));
  const int bottom = static_cast<int>(
      std::floor(std::clamp(index(disc.centre_image.y + half.y, origin.y), -1.0, intensity.rows - 1.0)));
  if (right < left || bottom < top) return {};
  return {left, top, right - left + 1, bottom - top + 1};
}

BinnedImage bin_image(const Photograph& photograph, std::span<const Disc> discs, int stride) {
  constexpr double kAround = 1.35;  // holds the background about the outermost discs
  double left = photograph.width(), right = -1.0, top = photograph.height(), bottom = -1.0;
  for (const Disc& disc : discs) {
    const cv::Point2d half = disc.half_extent_px(kAround);
    left = std::min(left, disc.centre_image.x - half.x);
    right = std::max(right, disc.centre_image.x + half.x);
    top = std::min(top, disc.centre_image.y - half.y);
    bottom = std::max(bottom, disc.centre_image.y + half.y);
  }
  BinnedImage image;
  image.stride = stride;
  image.saturation = photograph.saturation;
  const int x0 = static_cast<int>(std::max(0.0, std::floor(left)));
  const int y0 = static_cast<int>(std::max(0.0, std::floor(top)));
  const int columns = (static_cast<int>(std::min(right + 1.0, photograph.width() * 1.0)) - x0) / stride;
  const int rows = (static_cast<int>(std::min(bottom + 1.0, photograph.height() * 1.0)) - y0) / stride;
  image.origin = {x0, y0};
  if (columns <= 0 || rows <= 0) return image;
  const cv::Mat part = photograph.intensity(cv::Rect(x0, y0, columns * stride, rows * stride));
  if (stride == 1) {
    image.intensity = part;
  } else {
    cv::resize(part, image.intensity, cv::Size(columns, rows), 0, 0, cv::INTER_AREA);
  }
  return image;
}

void Shading::basis(float u, float v, float z, float* t) {
  t[0] = 1.0F;
  t[1] = u;
  t[2] = v;
  t[3] = u * u;
  t[4] = u * v;
  t[5] = v * v;
  t[6] = u * t[3];
  t[7] = u * t[4];
  t[8] = u * t[5];
  t[9] = v * t[5];
  for (int k = 0; k < 6; ++k) t[10 + k] = z * t[k];
}

std::vector<Shading> fit_shadings(const BinnedImage& image, std::span<const Disc> discs, int across) {
  std::vector<Shading> shadings(discs.size());
  if (image.intensity.empty()) return shadings;
  const auto background = backgrounds(image, discs);
  for (std::size_t k = 0; k < discs.size(); ++k) shadings[k].background = background[k];
  const Samples samples = take_samples(image, discs, shadings, across);
  const std::vector<Terms> terms = own_terms(samples, common_terms(samples));
  for (std::size_t k = 0; k < discs.size(); ++k)
    for (int a = 0; a < Shading::kTerms; ++a)
      shadings[k].terms[static_cast<std::size_t>(a)] = static_cast<float>(terms[k][a]);
  return shadings;
}

double beside_limbs(const EquatorLine& line, const Disc& disc, std::span<const Disc> discs,
                    std::span<const std::size_t> others) {
  constexpr double kFallsOff = 0.2;
  constexpr int kSteps = 40;
  const cv::Point2d along(std::cos(line.angle_rad), std::sin(line.angle_rad)), across(-along.y, along.x);
  int beside = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double t = kInner * (2.0 * (step + 0.5) / kSteps - 1.0);
    const double bend = std::sin(line.tilt_rad) * std::sqrt(1.0 - t * t);
    const cv::Point2d at = t * along + (line.offset + bend) * across;
    const cv::Vec2d off = disc.image_from_unit * cv::Vec2d(at.x, at.y);
    const cv::Point2d place = disc.centre_image + cv::Point2d(off[0], off[1]);
    const auto near_limb = [&](std::size_t other) {
      const double from = cv::norm(discs[other].unit(place.x, place.y)), wide = line.shape.half_width;
      return from > 1.0 - kFallsOff - wide && from < 1.0 + discs[other].rim + wide;
    };
    beside += std::ranges::any_of(others, near_limb) ? 1 : 0;
  }
  return static_cast<double>(beside) / kSteps;
}

}  // namespace strobe::digitize
