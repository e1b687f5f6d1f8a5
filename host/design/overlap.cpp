#include "host/design/overlap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace strobe::host {

namespace {

using reduction::PointPx;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

/// Where along an outline a disc begins (+1) or ends (-1).
struct Crossing {
  double at_rad = 0.0;
  int step = 0;
};

/// The part of the outline around `centre` that lies within the disc around `other`.
void add_disc(const PointPx& centre, const PointPx& other, double diameter_px,
              std::vector<Crossing>& crossings, std::size_t& around) {
  const double dx = other.x - centre.x, dy = other.y - centre.y;
  const double distance_px = std::hypot(dx, dy);
  if (distance_px >= diameter_px) return;
  const double half_rad = distance_px > 0.0 ? std::acos(distance_px / diameter_px) : std::numbers::pi;
  double from_rad = std::atan2(dy, dx) - half_rad;
  if (from_rad < 0.0) from_rad += kTurn_rad;
  double to_rad = from_rad + 2.0 * half_rad;
  if (to_rad >= kTurn_rad) {
    to_rad -= kTurn_rad;
    ++around;
  }
  crossings.push_back({from_rad, 1});
  crossings.push_back({to_rad, -1});
}

Overlap overlap_of(const std::vector<PointPx>& centres_px, std::size_t image, double diameter_px) {
  std::vector<Crossing> crossings;
  std::size_t depth = 0;
  for (std::size_t other = 0; other < centres_px.size(); ++other)
    if (other != image) add_disc(centres_px[image], centres_px[other], diameter_px, crossings, depth);
  // A disc at the same place begins where it ends.
  std::ranges::stable_sort(crossings, [](const Crossing& a, const Crossing& b) {
    return std::pair(a.at_rad, -a.step) < std::pair(b.at_rad, -b.step);
  });
  Overlap overlap{{}};
  double from_rad = 0.0;
  const auto add_until = [&](double to_rad) {
    overlap.shares[std::min(depth, kOverlapDepths - 1)] += (to_rad - from_rad) / kTurn_rad;
    from_rad = to_rad;
  };
  for (const Crossing& crossing : crossings) {
    add_until(crossing.at_rad);
    depth += static_cast<std::size_t>(crossing.step);
  }
  add_until(kTurn_rad);
  return overlap;
}

}  // namespace

std::vector<Overlap> overlaps(const std::vector<PointPx>& centres_px, double diameter_px) {
  std::vector<Overlap> all;
  for (std::size_t image = 0; image < centres_px.size(); ++image)
    all.push_back(overlap_of(centres_px, image, diameter_px));
  return all;
}

std::vector<double> overlap_shares(const std::vector<PointPx>& centres_px, double diameter_px) {
  std::vector<double> shares;
  for (const Overlap& overlap : overlaps(centres_px, diameter_px)) shares.push_back(overlap.share());
  return shares;
}

}  // namespace strobe::host
