#include "host/digitize/equator_shading.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace strobe::digitize {
namespace {

constexpr float kNoUse = -1.0F;
/// Nearer to the outline the sphere is too steep for low orders.
constexpr double kInner = 0.96;
constexpr int kSamplesAcross = 40;  ///< a disc
constexpr int kSweeps = 4;

/// One block under one disc.
struct Sample {
  int point = 0;  ///< which block
  std::array<float, Shading::kTerms> basis{};
};

struct Samples {
  std::vector<float> value;  ///< of each block: light less background
  std::vector<std::vector<Sample>> of_disc;
};

/// Median of the light around a disc and outside of all; absent: nothing is seen of it.
std::optional<float> background_about(const Blocks& blocks, std::span<const Disc> discs, const Disc& disc) {
  std::vector<float> values;
  constexpr int kDirections = 72;
  for (const double radii : {1.1, 1.2, 1.3}) {
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * CV_PI * k / kDirections;
      const cv::Vec2d away =
          disc.image_from_unit * cv::Vec2d(radii * std::cos(angle), radii * std::sin(angle));
      const cv::Point2d at = disc.centre_image + cv::Point2d(away[0], away[1]);
      const int i = static_cast<int>(std::lround((at.x + 0.5 - blocks.origin.x) / blocks.stride - 0.5));
      const int j = static_cast<int>(std::lround((at.y + 0.5 - blocks.origin.y) / blocks.stride - 0.5));
      if (i < 0 || j < 0 || i >= blocks.light.cols || j >= blocks.light.rows) continue;
      const bool covered = std::ranges::any_of(discs, [&](const Disc& other) {
        const cv::Point2d unit = other.unit(at.x, at.y);
        return unit.dot(unit) < (1.0 + other.rim) * (1.0 + other.rim);
      });
      if (!covered) values.push_back(blocks.light.at<float>(j, i));
    }
  }
  if (values.size() < kDirections / 8) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

std::vector<float> backgrounds(const Blocks& blocks, std::span<const Disc> discs) {
  std::vector<std::optional<float>> seen;
  std::vector<float> known;
  for (const Disc& disc : discs) {
    seen.push_back(background_about(blocks, discs, disc));
    if (seen.back()) known.push_back(*seen.back());
  }
  std::ranges::sort(known);
  const float usual = known.empty() ? 0.0F : known[known.size() / 2];
  std::vector<float> result;
  for (const auto& one : seen) result.push_back(one.value_or(usual));
  return result;
}

/// Discs whose rows are near a row.
std::vector<std::size_t> near_row(std::span<const Disc> discs, double row, double radii) {
  std::vector<std::size_t> near;
  for (std::size_t k = 0; k < discs.size(); ++k)
    if (std::abs(row - discs[k].centre_image.y) <= discs[k].half_extent_px(radii).y) near.push_back(k);
  return near;
}

Samples take_samples(const Blocks& blocks, std::span<const Disc> discs, std::span<const Shading> shadings) {
  double radius = 0.0;
  for (const Disc& disc : discs) radius = std::max(radius, disc.radius_image_px);
  const int step = std::max(1, static_cast<int>(2.0 * radius / blocks.stride / kSamplesAcross));
  Samples samples;
  samples.of_disc.resize(discs.size());
  std::vector<std::pair<std::size_t, cv::Point2d>> over;
  for (int j = 0; j < blocks.light.rows; j += step) {
    const auto near = near_row(discs, blocks.row(j), 1.1);
    if (near.empty()) continue;
    const float* light = blocks.light.ptr<float>(j);
    for (int i = 0; i < blocks.light.cols; i += step) {
      if (light[i] >= blocks.saturation) continue;
      over.clear();
      bool use = true;
      for (const std::size_t k : near) {
        const cv::Point2d unit = discs[k].unit(blocks.column(i), blocks.row(j));
        const double r = unit.dot(unit);
        if (r > (1.0 + discs[k].rim) * (1.0 + discs[k].rim)) continue;
        use = use && r < kInner * kInner && r < (1.0 - discs[k].rim) * (1.0 - discs[k].rim);
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
      samples.value.push_back(light[i] - background / static_cast<float>(over.size()));
    }
  }
  return samples;
}

using Normal = cv::Matx<double, Shading::kTerms, Shading::kTerms>;
using Terms = cv::Vec<double, Shading::kTerms>;

void add(Normal& normal, Terms& right, const float* basis, double weight, double value) {
  for (int a = 0; a < Shading::kTerms; ++a) {
    const double scaled = weight * basis[a];
    right[a] += scaled * value;
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

double dot(const Sample& sample, const Terms& terms) {
  double sum = 0.0;
  for (int a = 0; a < Shading::kTerms; ++a) sum += sample.basis[static_cast<std::size_t>(a)] * terms[a];
  return sum;
}

/// One shading for all discs: where each alone would not tell its own from its neighbours'.
Terms common_terms(const Samples& samples) {
  std::vector<std::array<float, Shading::kTerms>> sums(samples.value.size());
  for (const auto& disc : samples.of_disc)
    for (const Sample& sample : disc)
      for (std::size_t a = 0; a < Shading::kTerms; ++a)
        sums[static_cast<std::size_t>(sample.point)][a] += sample.basis[a];
  Normal normal = Normal::eye() * 1e-3;
  Terms right;
  for (std::size_t p = 0; p < sums.size(); ++p) add(normal, right, sums[p].data(), 1.0, samples.value[p]);
  return solved(normal, right).value_or(Terms());
}

/// Balls in turn, each to what the others leave (backfitting), drawn towards the common shading as far as
/// lamps' light varies from flash to flash and ball to ball.
std::vector<Terms> own_terms(const Samples& samples, const Terms& common) {
  constexpr double kDraw = 4.0;  // samples' worth
  std::vector<Terms> terms(samples.of_disc.size(), common);
  std::vector<double> left(samples.value.begin(), samples.value.end());
  for (const auto& disc : samples.of_disc)
    for (const Sample& sample : disc) left[static_cast<std::size_t>(sample.point)] -= dot(sample, common);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    // Huber's weights from the second sweep on, at 1.5 robust sd; lines are dark, so that the sd is taken
    // from the bright side alone.
    double limit = 1e30;
    if (sweep > 0) {
      std::vector<double> bright;
      for (const double x : left)
        if (x > 0.0) bright.push_back(x);
      if (bright.size() > 10) {
        const auto middle = bright.begin() + static_cast<std::ptrdiff_t>(bright.size() / 2);
        std::ranges::nth_element(bright, middle);
        limit = 1.5 * 1.4826 * *middle + 1e-9;
      }
    }
    for (std::size_t k = 0; k < terms.size(); ++k) {
      Normal normal = Normal::eye() * kDraw;
      Terms right = common * kDraw;
      for (const Sample& sample : samples.of_disc[k]) {
        const double residual = left[static_cast<std::size_t>(sample.point)];
        const double weight = std::abs(residual) <= limit ? 1.0 : limit / std::abs(residual);
        add(normal, right, sample.basis.data(), weight, residual + dot(sample, terms[k]));
      }
      const auto next = solved(normal, right);
      if (!next) continue;
      for (const Sample& sample : samples.of_disc[k])
        left[static_cast<std::size_t>(sample.point)] += dot(sample, terms[k]) - dot(sample, *next);
      terms[k] = *next;
    }
  }
  return terms;
}

/// One row of blocks under one disc.
void flatten_row(const Blocks& blocks, int j, const Disc& disc, const Shading& shading, float* left,
                 float* noise, float* background, float* count) {
  const double reach = 1.0 + disc.rim;
  const cv::Rect box = blocks.around(disc, reach);
  if (j < box.y || j >= box.y + box.height) return;
  const cv::Point2d first = disc.unit(blocks.column(box.x), blocks.row(j));
  const auto du = static_cast<float>(disc.unit_from_image(0, 0) * blocks.stride);
  const auto dv = static_cast<float>(disc.unit_from_image(1, 0) * blocks.stride);
  const auto outer = static_cast<float>(reach * reach);
  const auto inner = static_cast<float>((1.0 - disc.rim) * (1.0 - disc.rim));
  for (int i = 0; i < box.width; ++i) {
    const float u = static_cast<float>(first.x) + du * static_cast<float>(i);
    const float v = static_cast<float>(first.y) + dv * static_cast<float>(i);
    const float r = u * u + v * v;
    if (r > outer) continue;
    const int at = box.x + i;
    if (r > inner) {
      noise[at] = kNoUse;
      continue;
    }
    const float own = shading.at(u, v, std::sqrt(1.0F - r));
    left[at] -= own;
    if (noise[at] >= 0.0F) noise[at] += own * own;
    background[at] += shading.background;
    count[at] += 1.0F;
  }
}

}  // namespace

cv::Rect Blocks::around(const Disc& disc, double radii) const {
  const cv::Point2d half = disc.half_extent_px(radii);
  const auto index = [&](double px, int start) { return (px + 0.5 - start) / stride - 0.5; };
  const int left = static_cast<int>(
      std::ceil(std::clamp(index(disc.centre_image.x - half.x, origin.x), 0.0, light.cols * 1.0)));
  const int right = static_cast<int>(
      std::floor(std::clamp(index(disc.centre_image.x + half.x, origin.x), -1.0, light.cols - 1.0)));
  const int top = static_cast<int>(
      std::ceil(std::clamp(index(disc.centre_image.y - half.y, origin.y), 0.0, light.rows * 1.0)));
  const int bottom = static_cast<int>(
      std::floor(std::clamp(index(disc.centre_image.y + half.y, origin.y), -1.0, light.rows - 1.0)));
  if (right < left || bottom < top) return {};
  return {left, top, right - left + 1, bottom - top + 1};
}

Blocks cut_blocks(const Photograph& photograph, std::span<const Disc> discs, int stride) {
  constexpr double kAround = 1.35;  // holds the background about the outermost discs
  double left = photograph.width(), right = -1.0, top = photograph.height(), bottom = -1.0;
  for (const Disc& disc : discs) {
    const cv::Point2d half = disc.half_extent_px(kAround);
    left = std::min(left, disc.centre_image.x - half.x);
    right = std::max(right, disc.centre_image.x + half.x);
    top = std::min(top, disc.centre_image.y - half.y);
    bottom = std::max(bottom, disc.centre_image.y + half.y);
  }
  Blocks blocks;
  blocks.stride = stride;
  blocks.saturation = photograph.saturation;
  const int x0 = static_cast<int>(std::max(0.0, std::floor(left)));
  const int y0 = static_cast<int>(std::max(0.0, std::floor(top)));
  const int columns = (static_cast<int>(std::min(right + 1.0, photograph.width() * 1.0)) - x0) / stride;
  const int rows = (static_cast<int>(std::min(bottom + 1.0, photograph.height() * 1.0)) - y0) / stride;
  blocks.origin = {x0, y0};
  if (columns <= 0 || rows <= 0) return blocks;
  const cv::Mat part = photograph.light(cv::Rect(x0, y0, columns * stride, rows * stride));
  if (stride == 1) {
    blocks.light = part;
  } else {
    cv::resize(part, blocks.light, cv::Size(columns, rows), 0, 0, cv::INTER_AREA);
  }
  return blocks;
}

void Shading::basis(float u, float v, float z, float* t) {
  const float even = u * u - v * v;
  t[0] = 1.0F;
  t[1] = u;
  t[2] = v;
  t[3] = z;
  t[4] = u * v;
  t[5] = even;
  t[6] = u * z;
  t[7] = v * z;
  t[8] = z * z;
  t[9] = u * (even - 2.0F * v * v);
  t[10] = v * (even + 2.0F * u * u);
  t[11] = z * even;
  t[12] = z * u * v;
  t[13] = u * z * z;
  t[14] = v * z * z;
  t[15] = z * z * z;
}

float Shading::at(float u, float v, float z) const {
  std::array<float, kTerms> t;
  basis(u, v, z, t.data());
  float sum = 0.0F;
  for (std::size_t a = 0; a < kTerms; ++a) sum += terms[a] * t[a];
  return sum;
}

std::vector<Shading> fit_shadings(const Blocks& blocks, std::span<const Disc> discs) {
  std::vector<Shading> shadings(discs.size());
  if (blocks.light.empty()) return shadings;
  const auto background = backgrounds(blocks, discs);
  for (std::size_t k = 0; k < discs.size(); ++k) shadings[k].background = background[k];
  const Samples samples = take_samples(blocks, discs, shadings);
  const std::vector<Terms> terms = own_terms(samples, common_terms(samples));
  for (std::size_t k = 0; k < discs.size(); ++k)
    for (int a = 0; a < Shading::kTerms; ++a)
      shadings[k].terms[static_cast<std::size_t>(a)] = static_cast<float>(terms[k][a]);
  return shadings;
}

Flattened flatten(const Blocks& blocks, std::span<const Disc> discs, std::span<const Shading> shadings) {
  Flattened result;
  if (blocks.light.empty()) return result;
  result.left = blocks.light.clone();
  result.noise = cv::Mat::zeros(blocks.light.size(), CV_32F);
  cv::parallel_for_(cv::Range(0, blocks.light.rows), [&](const cv::Range& rows) {
    std::vector<float> background(static_cast<std::size_t>(blocks.light.cols));
    std::vector<float> count(background.size());
    for (int j = rows.start; j < rows.end; ++j) {
      std::ranges::fill(background, 0.0F);
      std::ranges::fill(count, 0.0F);
      auto* left = result.left.ptr<float>(j);
      auto* noise = result.noise.ptr<float>(j);
      for (std::size_t k = 0; k < discs.size(); ++k)
        flatten_row(blocks, j, discs[k], shadings[k], left, noise, background.data(), count.data());
      const float* light = blocks.light.ptr<float>(j);
      for (int i = 0; i < blocks.light.cols; ++i) {
        const auto at = static_cast<std::size_t>(i);
        if (count[at] > 0.0F) left[i] -= background[at] / count[at];
        if (count[at] == 0.0F || light[i] >= blocks.saturation) noise[i] = kNoUse;
      }
    }
  });
  return result;
}

void add_line(const Blocks& blocks, const Disc& disc, const Shading& shading, const DiscLine& line,
              float sign, cv::Mat& left) {
  const cv::Rect box = blocks.around(disc, 1.0);
  const LinePlace place(line);
  for (int j = box.y; j < box.y + box.height; ++j) {
    auto* row = left.ptr<float>(j);
    for (int i = box.x; i < box.x + box.width; ++i) {
      const cv::Point2d unit = disc.unit(blocks.column(i), blocks.row(j));
      const double r = unit.dot(unit);
      if (r >= 1.0) continue;
      const double f = place.across(unit.x, unit.y);
      if (std::abs(f) > line.shape.reach()) continue;
      const float own = shading.at(static_cast<float>(unit.x), static_cast<float>(unit.y),
                                   static_cast<float>(std::sqrt(1.0 - r)));
      row[i] += sign * own * static_cast<float>(-line.contrast * line.shape.darkness(f));
    }
  }
}

}  // namespace strobe::digitize
