#include "host/digitize/outline/circle_ransac.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {

namespace {

constexpr int kRays = 128;
constexpr int kLinesPerRay = 3;  // along which pixels are read
constexpr int kPeaksPerRay = 3;
constexpr int kHalfStep = 3;  // px averaged on each side of an edge
constexpr int kTrials = 400;

cv::Point2d direction(double ray) {
  const double angle = 2.0 * std::numbers::pi * ray / kRays;
  return {std::cos(angle), std::sin(angle)};
}

/// Intensity in polar coordinates, summed over a ray with its two neighbours and cumulative over the radius;
/// and the number of pixels.
class PolarSums {
 public:
  PolarSums(const Photograph& photograph, const LocalFrame& frame, double inner, double outer)
      : bins_(static_cast<int>(outer - inner) + 1) {
    const auto size = static_cast<std::size_t>(kRays * (bins_ + 1));
    std::vector<float> light(size, 0.0F), pixels(size, 0.0F);
    for (int ray = 0; ray < kRays; ++ray) {
      for (int line = 0; line < kLinesPerRay; ++line) {
        const cv::Point2d out = direction(ray + (line + 0.5) / kLinesPerRay - 0.5);
        read_line(photograph, frame, out, inner, &light[index(ray, 1)], &pixels[index(ray, 1)]);
      }
    }
    light_.assign(size, 0.0F);
    pixels_ = light_;
    for (int ray = 0; ray < kRays; ++ray) {
      for (int bin = 1; bin <= bins_; ++bin) {
        light_[index(ray, bin)] = light_[index(ray, bin - 1)] + with_neighbours(light, ray, bin);
        pixels_[index(ray, bin)] = pixels_[index(ray, bin - 1)] + with_neighbours(pixels, ray, bin);
      }
    }
  }
  int bins() const { return bins_; }

  /// Mean intensity of the kHalfStep bins before `bin` less that of the next kHalfStep. Returns 0 without
  /// pixels.
  float rise(int ray, int bin) const {
    const std::size_t at = index(ray, bin);
    const float before = pixels_[at] - pixels_[at - kHalfStep], after = pixels_[at + kHalfStep] - pixels_[at];
    if (before < kHalfStep || after < kHalfStep) return 0.0F;
    return (light_[at] - light_[at - kHalfStep]) / before - (light_[at + kHalfStep] - light_[at]) / after;
  }

 private:
  std::size_t index(int ray, int bin) const { return static_cast<std::size_t>(ray * (bins_ + 1) + bin); }

  void read_line(const Photograph& photograph, const LocalFrame& frame, cv::Point2d out, double inner,
                 float* light, float* pixels) const {
    const cv::Mat& all = photograph.intensity;
    const cv::Point2d from = frame.to_image(out * (inner + 0.5)) + cv::Point2d(0.5, 0.5);
    for (int bin = 0; bin < bins_; ++bin) {
      const cv::Point2d at = frame.is_uncalibrated()
                                 ? from + static_cast<double>(bin) * cv::Point2d(out.x, -out.y)
                                 : frame.to_image(out * (inner + bin + 0.5)) + cv::Point2d(0.5, 0.5);
      if (!(at.x >= 0.0 && at.y >= 0.0 && at.x < all.cols && at.y < all.rows)) continue;
      light[bin] += all.ptr<float>(static_cast<int>(at.y))[static_cast<int>(at.x)];
      pixels[bin] += 1.0F;
    }
  }

  float with_neighbours(const std::vector<float>& of, int ray, int bin) const {
    return of[index((ray + kRays - 1) % kRays, bin)] + of[index(ray, bin)] +
           of[index((ray + 1) % kRays, bin)];
  }

  int bins_;
  std::vector<float> light_, pixels_;
};

/// The clearest rises of each ray. Missing ones have weight 0.
struct Peaks {
  using Row = std::array<float, kRays>;
  std::array<Row, kPeaksPerRay> offset{};  ///< from the start radius, outwards
  std::array<Row, kPeaksPerRay> weight{};  ///< clearness, 0 to 1

  void put(int ray, float at, float clear) {
    const auto r = static_cast<std::size_t>(ray);
    std::size_t place = kPeaksPerRay;
    while (place > 0 && weight[place - 1][r] < clear) --place;
    for (std::size_t i = kPeaksPerRay - 1; i > place; --i) {
      offset[i][r] = offset[i - 1][r];
      weight[i][r] = weight[i - 1][r];
    }
    if (place == kPeaksPerRay) return;
    offset[place][r] = at;
    weight[place][r] = clear;
  }
  int count(int ray) const {
    int n = 0;
    while (n < kPeaksPerRay && weight[static_cast<std::size_t>(n)][static_cast<std::size_t>(ray)] > 0.0F) ++n;
    return n;
  }
};

/// Median magnitude of the rises.
float typical(std::vector<float> rises) {
  std::erase(rises, 0.0F);
  for (float& d : rises) d = std::abs(d);
  return upper_median(std::move(rises));
}

Peaks find_peaks(const PolarSums& sums, double inner, double radius) {
  const int bins = sums.bins();
  std::vector<float> rises(static_cast<std::size_t>(kRays * bins), 0.0F);
  for (int ray = 0; ray < kRays; ++ray)
    for (int bin = kHalfStep; bin + kHalfStep <= bins; ++bin)
      rises[static_cast<std::size_t>(ray * bins + bin)] = sums.rise(ray, bin);
  const float noise = typical(rises);
  const auto start = static_cast<float>(inner - radius);
  Peaks peaks;
  for (int ray = 0; ray < kRays; ++ray) {
    const float* rise = &rises[static_cast<std::size_t>(ray * bins)];
    for (int bin = 1; bin + 1 < bins; ++bin) {
      const float here = rise[bin], before = rise[bin - 1], after = rise[bin + 1];
      if (here <= noise || here < before || here <= after) continue;
      const float bend = before - 2.0F * here + after;
      const float part = bend < 0.0F ? 0.5F * (before - after) / bend : 0.0F;
      peaks.put(ray, start + static_cast<float>(bin) + part, here / (here + 2.0F * noise));
    }
  }
  return peaks;
}

/// Of the centre and the radius.
using Change = cv::Vec3d;

/// A generator of its own, so that results are the same everywhere.
class Random {
 public:
  int below(int count) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<int>((state_ >> 33) % static_cast<std::uint64_t>(count));
  }

 private:
  std::uint64_t state_ = 20261121;
};

class Consensus {
 public:
  Consensus(const Peaks& peaks, const CoarseSearch& search) : peaks_(peaks), search_(search) {
    for (int ray = 0; ray < kRays; ++ray) {
      const cv::Point2d d = direction(ray);
      cos_[static_cast<std::size_t>(ray)] = static_cast<float>(d.x);
      sin_[static_cast<std::size_t>(ray)] = static_cast<float>(d.y);
      if (peaks.count(ray) > 0) rays_.push_back(ray);
    }
    tolerance_ = static_cast<float>(std::max(1.5, 0.015 * search.radius_px));
  }
  bool enough() const { return rays_.size() >= 6; }

  Change best() const {
    Change best;
    double most = agreement(best);
    Random random;
    for (int trial = 0; trial < kTrials; ++trial) {
      Change change;
      if (!through_three(random, change) || !possible(change)) continue;
      const double score = agreement(change);
      if (score > most) most = score, best = change;
    }
    for (int step = 0; step < 4; ++step) best = refined(best);
    return best;
  }

  double agreement(const Change& change) const {
    const cv::v_float32x4 x = cv::v_setall_f32(static_cast<float>(change[0])),
                          y = cv::v_setall_f32(static_cast<float>(change[1])),
                          r = cv::v_setall_f32(static_cast<float>(change[2])),
                          sharpness = cv::v_setall_f32(1.0F / tolerance_), one = cv::v_setall_f32(1.0F);
    cv::v_float32x4 sum = cv::v_setzero_f32();
    for (std::size_t ray = 0; ray < kRays; ray += 4) {
      const cv::v_float32x4 predicted =
          cv::v_muladd(x, cv::v_load(&cos_[ray]), cv::v_muladd(y, cv::v_load(&sin_[ray]), r));
      cv::v_float32x4 most = cv::v_setzero_f32();
      for (std::size_t i = 0; i < kPeaksPerRay; ++i) {
        const cv::v_float32x4 off = (cv::v_load(&peaks_.offset[i][ray]) - predicted) * sharpness;
        most = cv::v_max(most, cv::v_load(&peaks_.weight[i][ray]) * (one - off * off));
      }
      sum = sum + most;
    }
    return cv::v_reduce_sum(sum) / kRays;
  }

 private:
  bool possible(const Change& change) const {
    const double radius = search_.radius_px + change[2];
    return std::hypot(change[0], change[1]) <= search_.reach_px && radius >= search_.radius_min_px &&
           radius <= search_.radius_max_px;
  }

  cv::Vec3d row(int ray) const {
    return {cos_[static_cast<std::size_t>(ray)], sin_[static_cast<std::size_t>(ray)], 1.0};
  }

  /// By Cramer's rule.
  bool through_three(Random& random, Change& change) const {
    std::array<cv::Vec3d, 3> rows;
    cv::Vec3d offsets;
    for (int i = 0; i < 3; ++i) {
      const int ray = rays_[static_cast<std::size_t>(random.below(static_cast<int>(rays_.size())))];
      rows[static_cast<std::size_t>(i)] = row(ray);
      const auto peak = static_cast<std::size_t>(random.below(peaks_.count(ray)));
      offsets[i] = peaks_.offset[peak][static_cast<std::size_t>(ray)];
    }
    const cv::Vec3d a = rows[1].cross(rows[2]), b = rows[2].cross(rows[0]), c = rows[0].cross(rows[1]);
    const double determinant = rows[0].dot(a);
    if (std::abs(determinant) < 0.1) return false;
    change = (offsets[0] * a + offsets[1] * b + offsets[2] * c) * (1.0 / determinant);
    return true;
  }

  Change refined(const Change& from) const {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Vec3d right;
    for (const int ray : rays_) {
      const cv::Vec3d g = row(ray);
      const double predicted = g.dot(from);
      double weight = 0.0, offset = 0.0;
      for (std::size_t i = 0; i < kPeaksPerRay; ++i) {
        const double here = peaks_.offset[i][static_cast<std::size_t>(ray)];
        const double off = (here - predicted) / tolerance_;
        const double score = peaks_.weight[i][static_cast<std::size_t>(ray)] * (1.0 - off * off);
        if (score > weight) weight = score, offset = here;
      }
      normal += weight * g * g.t();
      right += weight * offset * g;
    }
    // A weak prior, for short arcs.
    for (int a = 0; a < 3; ++a) normal(a, a) += 0.02, right[a] += 0.02 * from[a];
    return normal.solve(right, cv::DECOMP_CHOLESKY);
  }

  const Peaks& peaks_;
  CoarseSearch search_;
  Peaks::Row cos_{}, sin_{};
  std::vector<int> rays_;
  float tolerance_;
};

}  // namespace

std::optional<CoarseCircle> find_circle_ransac(const Photograph& photograph, const LocalFrame& frame,
                                               const CoarseSearch& search) {
  const double inner = std::max(1.0, search.radius_px - search.reach_px - kHalfStep - 1);
  const PolarSums sums(photograph, frame, inner, search.radius_px + search.reach_px + kHalfStep + 1);
  const Peaks peaks = find_peaks(sums, inner, search.radius_px);
  const Consensus consensus(peaks, search);
  if (!consensus.enough()) return std::nullopt;
  const Change change = consensus.best();
  return CoarseCircle{{change[0], change[1]}, search.radius_px + change[2], consensus.agreement(change)};
}

}  // namespace strobe::digitize
