#include "host/digitize/edge_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/digitize/annulus.hpp"

namespace strobe::digitize {

namespace {

constexpr int kRays = 128;
constexpr int kPeaksPerRay = 3;
constexpr int kHalfStep = 3;  // px averaged on each side of an edge
constexpr int kTrials = 400;

struct Peak {
  double offset = 0.0;  ///< from the start radius, outwards
  double weight = 0.0;  ///< clearness, 0 to 1
};

using Peaks = std::array<std::vector<Peak>, kRays>;

cv::Point2d direction(int ray) {
  const double angle = 2.0 * std::numbers::pi * ray / kRays;
  return {std::cos(angle), std::sin(angle)};
}

/// Mean light by ray and by radius; NaN where there is no pixel.
class PolarLight {
 public:
  PolarLight(const Photograph& photograph, const LocalFrame& frame, double inner, double outer)
      : inner_(inner), bins_(static_cast<int>(outer - inner) + 1) {
    sum_.assign(static_cast<std::size_t>(kRays * bins_), 0.0F);
    weight_ = sum_;
    visit_annulus(photograph, frame, {}, inner, outer, [&](cv::Point2d at, float light) {
      const double r = std::hypot(at.x, at.y);
      const int bin = static_cast<int>(r - inner_);
      if (bin < 0 || bin >= bins_) return;
      const double turn = cv::fastAtan2(static_cast<float>(at.y), static_cast<float>(at.x)) / 360.0;
      const int ray = static_cast<int>(turn * kRays + 0.5) % kRays;
      sum_[index(ray, bin)] += light;
      weight_[index(ray, bin)] += 1.0F;
    });
  }
  int bins() const { return bins_; }

  /// Mean over the bins [from, from + kHalfStep) of a ray and its two neighbours.
  double mean(int ray, int from) const {
    float sum = 0.0F, weight = 0.0F;
    for (int side = -1; side <= 1; ++side) {
      for (int bin = from; bin < from + kHalfStep; ++bin) {
        const std::size_t at = index((ray + side + kRays) % kRays, bin);
        sum += sum_[at];
        weight += weight_[at];
      }
    }
    return weight >= kHalfStep ? sum / weight : std::nan("");
  }

 private:
  std::size_t index(int ray, int bin) const { return static_cast<std::size_t>(ray * bins_ + bin); }
  double inner_;
  int bins_;
  std::vector<float> sum_, weight_;
};

/// Rises towards the centre by ray; [ray][bin] lies between bin - 1 and bin.
std::vector<std::vector<double>> rises(const PolarLight& light) {
  std::vector<std::vector<double>> all(kRays);
  for (int ray = 0; ray < kRays; ++ray) {
    auto& rise = all[static_cast<std::size_t>(ray)];
    rise.assign(static_cast<std::size_t>(light.bins()), 0.0);
    for (int bin = kHalfStep; bin + kHalfStep <= light.bins(); ++bin) {
      const double d = light.mean(ray, bin - kHalfStep) - light.mean(ray, bin);
      rise[static_cast<std::size_t>(bin)] = std::isfinite(d) ? d : 0.0;
    }
  }
  return all;
}

double typical(const std::vector<std::vector<double>>& all) {
  std::vector<double> sizes;
  for (const auto& rise : all)
    for (const double d : rise)
      if (d != 0.0) sizes.push_back(std::abs(d));
  if (sizes.empty()) return 0.0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

Peaks find_peaks(const PolarLight& light, double inner, double radius) {
  const auto all = rises(light);
  const double noise = typical(all);
  Peaks peaks;
  for (std::size_t ray = 0; ray < kRays; ++ray) {
    const auto& rise = all[ray];
    for (std::size_t bin = 1; bin + 1 < rise.size(); ++bin) {
      const double here = rise[bin], before = rise[bin - 1], after = rise[bin + 1];
      if (here <= noise || here < before || here <= after) continue;
      const double bend = before - 2.0 * here + after;
      const double part = bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
      peaks[ray].push_back({inner + static_cast<double>(bin) + part - radius, here / (here + 2.0 * noise)});
    }
    std::sort(peaks[ray].begin(), peaks[ray].end(),
              [](const Peak& a, const Peak& b) { return a.weight > b.weight; });
    if (peaks[ray].size() > kPeaksPerRay) peaks[ray].resize(kPeaksPerRay);
  }
  return peaks;
}

/// Shift of the centre and growth of the radius.
using Change = cv::Vec3d;

/// A sequence of its own, so that results repeat everywhere.
class Draw {
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
  Consensus(const Peaks& peaks, const RoughSearch& search) : peaks_(peaks), search_(search) {
    for (int ray = 0; ray < kRays; ++ray) {
      directions_[static_cast<std::size_t>(ray)] = direction(ray);
      if (!peaks[static_cast<std::size_t>(ray)].empty()) rays_.push_back(ray);
    }
    tolerance_ = std::max(1.5, 0.015 * search.radius_px);
  }
  bool enough() const { return rays_.size() >= 6; }

  Change best() const {
    Change best;
    double most = agreement(best);
    Draw draw;
    for (int trial = 0; trial < kTrials; ++trial) {
      Change change;
      if (!through_three(draw, change) || !possible(change)) continue;
      const double score = agreement(change);
      if (score > most) most = score, best = change;
    }
    for (int step = 0; step < 4; ++step) best = refined(best);
    return best;
  }

  double agreement(const Change& change) const {
    double sum = 0.0;
    for (const int ray : rays_) sum += nearest(ray, change).second;
    return sum / kRays;
  }

 private:
  /// The ray's peak that agrees best, and how well.
  std::pair<const Peak*, double> nearest(int ray, const Change& change) const {
    const cv::Point2d d = directions_[static_cast<std::size_t>(ray)];
    const double predicted = change[0] * d.x + change[1] * d.y + change[2];
    std::pair<const Peak*, double> best{nullptr, 0.0};
    for (const Peak& peak : peaks_[static_cast<std::size_t>(ray)]) {
      const double off = (peak.offset - predicted) / tolerance_;
      const double score = peak.weight * (1.0 - off * off);
      if (score > best.second) best = {&peak, score};
    }
    return best;
  }

  bool possible(const Change& change) const {
    const double radius = search_.radius_px + change[2];
    return std::hypot(change[0], change[1]) <= search_.reach_px && radius >= search_.radius_min_px &&
           radius <= search_.radius_max_px;
  }

  bool through_three(Draw& draw, Change& change) const {
    cv::Matx33d rows;
    cv::Vec3d offsets;
    for (int i = 0; i < 3; ++i) {
      const int ray = rays_[static_cast<std::size_t>(draw.below(static_cast<int>(rays_.size())))];
      const auto& peaks = peaks_[static_cast<std::size_t>(ray)];
      const cv::Point2d d = directions_[static_cast<std::size_t>(ray)];
      for (int a = 0; a < 3; ++a) rows(i, a) = a == 0 ? d.x : a == 1 ? d.y : 1.0;
      offsets[i] = peaks[static_cast<std::size_t>(draw.below(static_cast<int>(peaks.size())))].offset;
    }
    if (std::abs(cv::determinant(rows)) < 0.1) return false;
    change = rows.solve(offsets, cv::DECOMP_LU);
    return true;
  }

  Change refined(const Change& from) const {
    cv::Matx33d normal = cv::Matx33d::zeros();
    cv::Vec3d right;
    for (const int ray : rays_) {
      const auto [peak, weight] = nearest(ray, from);
      if (peak == nullptr) continue;
      const cv::Point2d d = directions_[static_cast<std::size_t>(ray)];
      const cv::Vec3d row(d.x, d.y, 1.0);
      normal += weight * row * row.t();
      right += weight * peak->offset * row;
    }
    // A weak hold on the start, for arcs too short to tell.
    for (int a = 0; a < 3; ++a) normal(a, a) += 0.02, right[a] += 0.02 * from[a];
    return normal.solve(right, cv::DECOMP_CHOLESKY);
  }

  const Peaks& peaks_;
  RoughSearch search_;
  std::array<cv::Point2d, kRays> directions_;
  std::vector<int> rays_;
  double tolerance_;
};

}  // namespace

std::optional<RoughCircle> search_circle(const Photograph& photograph, const LocalFrame& frame,
                                         const RoughSearch& search) {
  const double inner = std::max(1.0, search.radius_px - search.reach_px - kHalfStep - 1);
  const PolarLight light(photograph, frame, inner, search.radius_px + search.reach_px + kHalfStep + 1);
  const Peaks peaks = find_peaks(light, inner, search.radius_px);
  const Consensus consensus(peaks, search);
  if (!consensus.enough()) return std::nullopt;
  const Change change = consensus.best();
  return RoughCircle{{change[0], change[1]}, search.radius_px + change[2], consensus.agreement(change)};
}

}  // namespace strobe::digitize
