#include "host/digitize/transfer/transfer_curve.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <vector>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

struct BallDisc {
  cv::Point2d centre;  ///< image px
  double radius = 0.0;
  double blur = 0.0;

  double depth(cv::Point2d p) const { return radius - cv::norm(p - centre); }
};

/// A crossing of two outlines, with the directions into either disc, of length 1.
struct Crossing {
  cv::Point2d at, into_a, into_b;
};

std::vector<BallDisc> discs_of(const PlaneMap& map, std::span<const Outline> outlines) {
  std::vector<BallDisc> discs;
  for (const Outline& o : outlines) {
    const cv::Point2d centre = map.to_image(o.centre);
    const double scale = map.image_px_per_plane_px(centre);
    discs.push_back({centre, 0.5 * o.diameter * scale, o.blur_px * scale});
  }
  return discs;
}

std::vector<Crossing> crossings_of(const BallDisc& a, const BallDisc& b) {
  const cv::Point2d way = b.centre - a.centre;
  const double apart = cv::norm(way);
  if (!(apart > std::abs(a.radius - b.radius)) || !(apart < a.radius + b.radius)) return {};
  const double along = 0.5 * (apart + (a.radius * a.radius - b.radius * b.radius) / apart);
  const double aside = std::sqrt(std::max(0.0, a.radius * a.radius - along * along));
  const cv::Point2d u = way * (1.0 / apart), v(-u.y, u.x);
  std::vector<Crossing> found;
  for (const double side : {1.0, -1.0}) {
    const cv::Point2d at = a.centre + u * along + v * (side * aside);
    found.push_back({at, (a.centre - at) * (1.0 / a.radius), (b.centre - at) * (1.0 / b.radius)});
  }
  return found;
}

/// Mean over a disc of `radius` px; absent at the border and where a pixel is saturated.
std::optional<double> mean_at(const Photograph& photograph, cv::Point2d at, double radius) {
  const int half = static_cast<int>(radius), column = cvRound(at.x), row = cvRound(at.y);
  if (column < half || row < half || column + half >= photograph.width() || row + half >= photograph.height())
    return std::nullopt;
  double sum = 0.0;
  for (int y = row - half; y <= row + half; ++y) {
    for (int x = column - half; x <= column + half; ++x) {
      const float value = photograph.intensity.at<float>(y, x);
      if (value >= photograph.saturation) return std::nullopt;
      sum += static_cast<double>(value);
    }
  }
  return sum / ((2.0 * half + 1.0) * (2.0 * half + 1.0));
}

/// Numbers in both, in one, in the other and in none, equally deep within or outside of either outline.
struct Quad {
  double both = 0.0, one = 0.0, other = 0.0, none = 0.0;

  /// By how much light would fail to add up, over that in both, were light number^power.
  double excess(double power) const {
    const auto light = [&](double number) { return std::pow(std::max(number, 0.0) / both, power); };
    return 1.0 + light(none) - light(one) - light(other);
  }
};

cv::Point2d turned(cv::Point2d p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y};
}

/// Whether a limb lies between two places, or within `margin` of either.
bool limb_between(std::span<const BallDisc> discs, const BallDisc& own, cv::Point2d p, cv::Point2d q,
                  double margin) {
  return std::ranges::any_of(discs, [&](const BallDisc& disc) {
    if (&disc == &own) return false;
    const double at_p = disc.depth(p), at_q = disc.depth(q);
    return at_p * at_q <= 0.0 || std::min(std::abs(at_p), std::abs(at_q)) < margin;
  });
}

/// What a disc shows alone where it lies below the other, from two places outside of that, as deep in it and
/// in steps of the same angle: light changes along the limb.
std::optional<double> alone(const Photograph& photograph, std::span<const BallDisc> discs,
                            const BallDisc& disc, cv::Point2d both, cv::Point2d outside, double radius) {
  const cv::Point2d from = both - disc.centre, to = outside - disc.centre;
  const double turn = std::atan2(from.cross(to), from.dot(to));
  std::array<double, 2> seen{};
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const cv::Point2d at = disc.centre + turned(to, static_cast<double>(i) * turn);
    const auto mean = mean_at(photograph, at, radius);
    if (!mean || limb_between(discs, disc, outside, at, radius)) return std::nullopt;
    seen[i] = *mean;
  }
  return 2.0 * seen[0] - seen[1];
}

std::optional<Quad> quad_at(const Photograph& photograph, std::span<const BallDisc> discs, const BallDisc& a,
                            const BallDisc& b, const Crossing& c, double depth) {
  const double cosine = c.into_a.dot(c.into_b);
  // Outlines that graze each other have no place that is deep in one and outside of the other nearby.
  constexpr double kMaxCosine = 0.8;
  if (std::abs(cosine) > kMaxCosine) return std::nullopt;
  const cv::Point2d inward = (c.into_a + c.into_b) * (depth / (1.0 + cosine));
  const cv::Point2d across = (c.into_a - c.into_b) * (depth / (1.0 - cosine));
  const double radius = std::max(1.0, 0.4 * depth);
  const auto both = mean_at(photograph, c.at + inward, radius),
             none = mean_at(photograph, c.at - inward, radius);
  const auto one = alone(photograph, discs, a, c.at + inward, c.at + across, radius);
  const auto other = alone(photograph, discs, b, c.at + inward, c.at - across, radius);
  if (!both || !none || !one || !other) return std::nullopt;
  const Quad quad{*both, *one, *other, *none};
  if (!(quad.both > 0.0) || !(quad.one > quad.none) || !(quad.other > quad.none)) return std::nullopt;
  return quad;
}

/// The power of the numbers that makes light add up; absent if none between a quarter and four does.
std::optional<double> power_of(const Quad& quad) {
  double low = 0.25, high = 4.0;
  if (!(quad.excess(low) < 0.0) || !(quad.excess(high) > 0.0)) return std::nullopt;
  for (int i = 0; i < 40; ++i) {
    const double middle = std::sqrt(low * high);
    (quad.excess(middle) < 0.0 ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

bool clear_of_others(std::span<const BallDisc> discs, std::size_t a, std::size_t b, cv::Point2d at,
                     double margin) {
  for (std::size_t k = 0; k < discs.size(); ++k) {
    if (k != a && k != b && std::abs(discs[k].depth(at)) < margin) return false;
  }
  return true;
}

/// Clear of the limb's blur, and shallow against how light changes over the ball.
double depth_in(const BallDisc& disc) { return 0.03 * disc.radius + 2.0 * disc.blur + 1.0; }

/// By how much light that bends along the limb as a cosine does misleads, as a share of the power: two steps
/// of about twice the depth are bridged straight on, and of light that is halved the power takes 1 / ln 2.
double by_bend(std::span<const BallDisc> discs) {
  double largest = 0.0;
  for (const BallDisc& disc : discs) largest = std::max(largest, 2.0 * depth_in(disc) / disc.radius);
  return largest * largest / std::numbers::ln2;
}

std::vector<double> log_powers(const Photograph& photograph, std::span<const BallDisc> discs) {
  std::vector<double> powers;
  for (std::size_t a = 0; a < discs.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double depth = depth_in(discs[a]);
      for (const Crossing& c : crossings_of(discs[a], discs[b])) {
        if (!clear_of_others(discs, a, b, c.at, 3.0 * depth)) continue;
        const auto quad = quad_at(photograph, discs, discs[a], discs[b], c, depth);
        const auto power = quad ? power_of(*quad) : std::nullopt;
        if (power) powers.push_back(std::log(*power));
      }
    }
  }
  return powers;
}

}  // namespace

bool TransferCurve::is_proportional() const {
  // 0.85 widens no ball by more than the sd of its diameter, and no screen or camera writes an exponent
  // between it and 1.
  // Felt's grain and print scatter single crossings by a fifth.
  constexpr double kMatters = 0.15, kOfMarks = 0.6;
  if (scatter > kOfMarks) return true;
  return std::abs(exponent - 1.0) < std::max(kFarthest_sd * sd, kMatters);
}

std::optional<TransferCurve> measure_transfer(const Photograph& photograph, const PlaneMap& map,
                                              std::span<const Outline> outlines) {
  constexpr std::size_t kMinPowers = 5;
  const std::vector<BallDisc> discs = discs_of(map, outlines);
  const std::vector<double> powers = log_powers(photograph, discs);
  if (powers.size() < kMinPowers) return std::nullopt;
  const double middle = upper_median(powers);
  std::vector<double> off;
  for (const double power : powers) off.push_back(std::abs(power - middle));
  const double scatter = kSdOverMad * upper_median(off);
  const double noise = kSdOfMedian * scatter / std::sqrt(static_cast<double>(powers.size()));
  const double sd = std::hypot(noise, by_bend(discs));
  const double exponent = std::exp(-middle);
  return TransferCurve{exponent, exponent * sd, static_cast<int>(powers.size()), scatter};
}

Photograph linearized(const Photograph& photograph, const TransferCurve& curve) {
  assert(curve.exponent > 0.0);
  Photograph light = photograph;
  light.intensity.release();  // which both share
  cv::pow(cv::max(photograph.intensity, 0.0), 1.0 / curve.exponent, light.intensity);
  light.saturation =
      static_cast<float>(std::pow(static_cast<double>(photograph.saturation), 1.0 / curve.exponent));
  return light;
}

}  // namespace strobe::digitize
