#include "host/digitize/outliers/limb_agreement.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <opencv2/core/utility.hpp>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

constexpr std::size_t kDirections = std::tuple_size_v<Limb>;
constexpr int kAcross = 3;  // samples along the outline, for one direction
constexpr std::ptrdiff_t kMinOutlines = 3;
constexpr double kHalf = 0.5, kNearlyWhole = 0.75;
constexpr float kMinGain = 0.7F;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

struct OutlinePlace {
  cv::Point2d centre;
  EllipsePx ellipse;
  double reach(double angle_rad) const {
    const double a = angle_rad - ellipse.axis_rad;
    return 1.0 / std::hypot(std::cos(a) / ellipse.along, std::sin(a) / ellipse.across);
  }
};

class Reader {
 public:
  Reader(const Photograph& photograph, const PlaneMap& map, const std::optional<SurfaceLine>& surface)
      : photograph_(photograph), map_(map) {
    if (surface) axes_ = surface_frame(*surface);
  }

  Limb limb(const Outline& outline) const {
    const OutlinePlace place{outline.centre, map_.outline(outline.centre, outline.diameter)};
    // Beyond most of the blur, and near enough that what lies under the ball is the same.
    const double off = 1.5 * std::max(outline.blur_px, 0.7) + 0.5;
    Limb limb{};
    for (std::size_t k = 0; k < kDirections; ++k) {
      float inside = 0.0F, outside = 0.0F;
      for (int j = 0; j < kAcross; ++j) {
        const double turn = (static_cast<double>(k) + (j + 0.5) / kAcross) / kDirections;
        inside += light(place, 2.0 * std::numbers::pi * turn, -off) +
                  light(place, 2.0 * std::numbers::pi * turn, -off - 1.5);
        outside += light(place, 2.0 * std::numbers::pi * turn, off) +
                   light(place, 2.0 * std::numbers::pi * turn, off + 1.5);
      }
      limb[k] = (inside - outside) / (2.0F * kAcross);
    }
    return limb;
  }

 private:
  float light(const OutlinePlace& place, double angle_rad, double beyond) const {
    const double r = place.reach(angle_rad) + beyond;
    const cv::Point2d at = place.ellipse.centre + r * cv::Point2d(std::cos(angle_rad), std::sin(angle_rad));
    if (axes_ && axes_->from_image(to_eigen(at)).y() < 0.0) return kNone;
    const cv::Point2d image = map_.to_image(at);
    const int column = cvRound(image.x), row = cvRound(image.y);
    if (column < 0 || row < 0 || column >= photograph_.width() || row >= photograph_.height()) return kNone;
    const float light = photograph_.intensity.at<float>(row, column);
    return light >= 0.985F * photograph_.saturation ? kNone : light;
  }

  const Photograph& photograph_;
  const PlaneMap& map_;
  std::optional<geometry::SurfaceFrame> axes_;
};

/// Median over the directions, or the outlines, that can be observed.
float median_rise(std::vector<double> rises) {
  std::erase_if(rises, [](double r) { return std::isnan(r); });
  return rises.empty() ? kNone : static_cast<float>(median(std::move(rises)));
}

/// From how much of an outline on it counts for the typical limb. Arcs of several things are hardly seen for
/// more than half; where background is busy they outnumber the balls, and a single ball that is seen nearly
/// whole tells more than all of them.
double min_visible_for_typical(std::span<const Outline> outlines) {
  const auto seen_for = [&](double visible) {
    return std::ranges::count_if(outlines, [&](const Outline& o) { return o.visible_fraction >= visible; });
  };
  if (seen_for(kHalf) >= kMinOutlines) return kHalf;
  return seen_for(kNearlyWhole) > 0 ? kNearlyWhole : 0.0;
}

Limb typical_limb(std::span<const Outline> outlines, const std::vector<Limb>& limbs) {
  const double visible = min_visible_for_typical(outlines);
  Limb typical{};
  for (std::size_t k = 0; k < kDirections; ++k) {
    std::vector<double> rises;
    for (std::size_t i = 0; i < limbs.size(); ++i)
      if (outlines[i].visible_fraction >= visible) rises.push_back(limbs[i][k]);
    typical[k] = median_rise(std::move(rises));
  }
  return typical;
}

/// Brightness of this image over the others', from the brightest quarter of its directions: flashes differ in
/// energy and light the middle more than the sides, within limits.
float gain_of(const Limb& limb, const Limb& typical) {
  std::vector<float> ratios;
  for (std::size_t k = 0; k < kDirections; ++k) {
    if (std::isnan(limb[k]) || !(typical[k] > 0.0F)) continue;
    ratios.push_back(limb[k] / typical[k]);
  }
  if (ratios.empty()) return 1.0F;
  return std::clamp(quantile(std::move(ratios), 3, 4), kMinGain, 1.0F);
}

LimbAgreement compared(const Limb& limb, const Limb& typical) {
  LimbAgreement result;
  result.limb = limb;
  const float gain = gain_of(limb, typical);
  double there = 0.0, expected = 0.0;
  for (std::size_t k = 0; k < kDirections; ++k) {
    if (std::isnan(limb[k])) continue;
    result.observed += 1.0 / kDirections;
    if (std::isnan(typical[k]) || typical[k] <= 0.0F) continue;
    expected += typical[k];
    there += limb[k] > 0.5F * gain * typical[k] ? typical[k] : 0.0F;
  }
  result.agreement = expected > 0.0 ? there / expected : 0.0;
  return result;
}

}  // namespace

std::vector<LimbAgreement> compare_limbs(const Photograph& photograph, const PlaneMap& map,
                                         std::span<const Outline> outlines,
                                         const std::optional<SurfaceLine>& surface) {
  const Reader reader(photograph, map, surface);
  std::vector<Limb> limbs(outlines.size());
  cv::parallel_for_(cv::Range(0, static_cast<int>(outlines.size())), [&](const cv::Range& range) {
    for (auto i = static_cast<std::size_t>(range.start); i < static_cast<std::size_t>(range.end); ++i)
      limbs[i] = reader.limb(outlines[i]);
  });
  Limb typical{};
  if (std::ssize(limbs) >= kMinOutlines) typical = typical_limb(outlines, limbs);
  std::vector<LimbAgreement> result;
  for (const Limb& limb : limbs) {
    if (std::ssize(limbs) < kMinOutlines) typical.fill(median_rise({limb.begin(), limb.end()}));
    result.push_back(compared(limb, typical));
  }
  assert(result.size() == outlines.size());
  return result;
}

}  // namespace strobe::digitize
