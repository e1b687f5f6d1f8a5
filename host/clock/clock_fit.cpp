#include "host/clock/clock_fit.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace strobe::host {
namespace {

using Points = std::vector<ClockSample>;

constexpr double kTukey = 4.685;  // 95 % as good as least squares where delays are normal
constexpr double kHuber = 2.5;
constexpr double kMinSpread_s = 1e-9;
constexpr int kMaxReweightings = 60;

struct Trend {
  double at_centre = 0.0;
  double drift = 0.0;
};

double left_turn(const ClockSample& a, const ClockSample& b, const ClockSample& c) {
  return (b.sent_s - a.sent_s) * (c.offset_s - a.offset_s) -
         (b.offset_s - a.offset_s) * (c.sent_s - a.sent_s);
}

/// The edge of the lower convex hull over the points' mean. Points in order of their sending.
Trend envelope(const Points& points, double centre) {
  Points hull;
  for (const ClockSample& point : points) {
    while (!hull.empty() && hull.back().sent_s == point.sent_s && hull.back().offset_s >= point.offset_s)
      hull.pop_back();
    if (!hull.empty() && hull.back().sent_s == point.sent_s) continue;
    while (hull.size() >= 2 && left_turn(hull[hull.size() - 2], hull.back(), point) <= 0.0) hull.pop_back();
    hull.push_back(point);
  }
  std::size_t right = 1;
  while (right + 1 < hull.size() && hull[right].sent_s < centre) ++right;
  const ClockSample& a = hull[right - 1];
  const ClockSample& b = hull[right];
  const double drift = (b.offset_s - a.offset_s) / (b.sent_s - a.sent_s);
  return {a.offset_s + drift * (centre - a.sent_s), drift};
}

double above(const ClockSample& point, const Trend& line, double centre) {
  return point.offset_s - line.at_centre - line.drift * (point.sent_s - centre);
}

/// From those on the early side alone: the others are late by any amount.
double spread_below(const Points& points, const Trend& line, double centre) {
  double squares = 0.0;
  int early = 0;
  for (const ClockSample& point : points) {
    const double r = above(point, line, centre);
    if (r > 0.0) continue;
    squares += r * r;
    ++early;
  }
  return early == 0 ? kMinSpread_s : std::max(kMinSpread_s, std::sqrt(squares / early));
}

double weight_of(double in_spreads) {
  if (in_spreads < 0.0) return in_spreads < -kHuber ? -kHuber / in_spreads : 1.0;
  if (in_spreads >= kTukey) return 0.0;
  const double share = in_spreads / kTukey;
  return (1.0 - share * share) * (1.0 - share * share);
}

struct ClockFit {
  Trend line;
  double spread = 0.0;
  int used = 0;
};

/// One step of reweighted least squares.
ClockFit improved(const Points& points, const ClockFit& before, double centre) {
  double w0 = 0.0, wx = 0.0, wy = 0.0, wxx = 0.0, wxy = 0.0;
  ClockFit fit = before;
  fit.used = 0;
  for (const ClockSample& point : points) {
    const double w = weight_of(above(point, before.line, centre) / before.spread);
    if (w <= 0.0) continue;
    ++fit.used;
    const double x = point.sent_s - centre;
    w0 += w, wx += w * x, wy += w * point.offset_s, wxx += w * x * x, wxy += w * x * point.offset_s;
  }
  const double determinant = w0 * wxx - wx * wx;
  if (!(determinant > 0.0)) return fit;
  fit.line.drift = (w0 * wxy - wx * wy) / determinant;
  fit.line.at_centre = (wy - fit.line.drift * wx) / w0;
  fit.spread = spread_below(points, fit.line, centre);
  return fit;
}

/// Half-way up among the usual delays, if one message in three has an unusual one.
ClockFit start_of(const Points& points, double centre) {
  Trend line = envelope(points, centre);
  std::vector<double> heights;
  for (const ClockSample& point : points) heights.push_back(above(point, line, centre));
  const auto third = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 3);
  std::nth_element(heights.begin(), third, heights.end());
  line.at_centre += *third;
  return {line, spread_below(points, line, centre), 0};
}

ClockFit converged(const Points& points, ClockFit fit, double centre) {
  for (int i = 0; i < kMaxReweightings; ++i) {
    const ClockFit next = improved(points, fit, centre);
    const double moved = std::abs(next.line.at_centre - fit.line.at_centre);
    fit = next;
    if (moved < 1e-4 * fit.spread) break;
  }
  return fit;
}

Points by_sending(std::span<const ClockSample> given) {
  Points points(given.begin(), given.end());
  std::sort(points.begin(), points.end(),
            [](const ClockSample& a, const ClockSample& b) { return a.sent_s < b.sent_s; });
  return points;
}

}  // namespace

std::optional<ClockLine> fit_clock(std::span<const ClockSample> given) {
  if (given.size() < kMinSamplesForLine) return std::nullopt;
  const Points points = by_sending(given);
  if (!(points.front().sent_s < points.back().sent_s)) return std::nullopt;
  double centre = 0.0;
  for (const ClockSample& point : points) centre += point.sent_s / static_cast<double>(points.size());
  const ClockFit fit = converged(points, start_of(points, centre), centre);
  ClockLine line;
  line.centre_s = centre;
  line.offset_at_centre_s = fit.line.at_centre;
  line.drift = fit.line.drift;
  line.spread_s = fit.spread;
  line.used = fit.used;
  return line;
}

}  // namespace strobe::host
