#include "host/digitize/path/path_order.hpp"

#include <algorithm>
#include <cmath>

#include "host/digitize/path/flight_legs.hpp"
#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {
namespace {

cv::Point2d place_of(std::span<const PathPoint> points, int i) {
  return points[static_cast<std::size_t>(i)].at;
}

double mean_x(std::span<const PathPoint> points, const std::vector<int>& members) {
  double sum = 0.0;
  for (const int i : members) sum += place_of(points, i).x / static_cast<double>(members.size());
  return sum;
}

/// For each leg the images in contact after it; the first list is that of contacts before any leg.
std::vector<std::vector<int>> contacts_after(std::span<const PathPoint> points, const Path& path) {
  std::vector<std::vector<int>> after(path.legs.size() + 1);
  for (const int i : path.contact) {
    // Of a bounce between two legs, or at the end of the leg alone, which begins far from the surface.
    std::size_t best = path.legs.size();
    double least = 1e300;
    for (std::size_t k = 0; k + 1 < path.legs.size(); ++k) {
      const double bounce_x =
          0.5 * (place_of(points, path.legs[k].back()).x + place_of(points, path.legs[k + 1].front()).x);
      if (std::abs(bounce_x - place_of(points, i).x) >= least) continue;
      least = std::abs(bounce_x - place_of(points, i).x);
      best = k + 1;
    }
    after[best].push_back(i);
  }
  return after;
}

/// Contacts come by x: turned round where the path goes to the left.
void sort_contacts(double towards, std::vector<std::vector<int>>& contacts) {
  if (towards >= 0.0) return;
  for (auto& images : contacts) std::ranges::reverse(images);
}

/// Of the path from its first leg on.
double towards_of(std::span<const PathPoint> points, const Path& path) {
  if (path.bounces())
    return mean_x(points, path.legs.front()) <= mean_x(points, path.legs.back()) ? 1.0 : -1.0;
  if (path.legs.empty()) return 1.0;
  const auto& leg = path.legs.front();
  if (leg.size() >= 2) return place_of(points, leg.back()).x >= place_of(points, leg.front()).x ? 1.0 : -1.0;
  if (path.contact.empty()) return 1.0;
  return place_of(points, leg.front()).x <= mean_x(points, path.contact) ? 1.0 : -1.0;
}

int chosen_bounce(const std::vector<std::vector<int>>& legs, std::optional<int> asked) {
  const int bounces = std::max(0, static_cast<int>(legs.size()) - 1);
  if (bounces == 0) return 0;
  if (asked && *asked >= 1 && *asked <= bounces) return *asked;
  for (int b = 1; b <= bounces; ++b) {
    const auto k = static_cast<std::size_t>(b);
    if (legs[k - 1].size() >= 2 && legs[k].size() >= 2) return b;
  }
  return 1;
}

void append(PathOrder& order, const std::vector<int>& images, std::optional<Leg> leg) {
  order.sequence.insert(order.sequence.end(), images.begin(), images.end());
  order.leg.insert(order.leg.end(), images.size(), leg);
}

/// Height of a leg's top, or of its highest image where the top is not among its images.
struct Top {
  double y = 0.0;
  bool seen = false;
};

Top top_of(std::span<const PathPoint> points, const std::vector<int>& leg, double diameter_px) {
  Top top{place_of(points, leg.front()).y, false};
  for (const int i : leg) top.y = std::max(top.y, place_of(points, i).y);
  const auto [left, right] = std::ranges::minmax(leg, {}, [&](int i) { return place_of(points, i).x; });
  const auto curve = FlightCurve::fit(points, leg, diameter_px);
  if (!curve) return top;
  double from = place_of(points, left).x, to = place_of(points, right).x;
  const auto rises = [&](double x) { return curve->slope(x).value_or(0.0) > 0.0; };
  if (!rises(from) || rises(to)) return top;
  for (int round = 0; round < 40; ++round) (rises(0.5 * (from + to)) ? from : to) = 0.5 * (from + to);
  return {std::max(top.y, curve->height(from).value_or(top.y)), true};
}

}  // namespace

PathOrder path_order(std::span<const PathPoint> points, const Path& path, bool reversed,
                     std::optional<int> bounce) {
  PathOrder order;
  order.legs = path.legs;
  order.towards = towards_of(points, path);
  auto contacts = contacts_after(points, path);
  sort_contacts(order.towards, contacts);
  if (reversed) {
    order.towards = -order.towards;
    std::ranges::reverse(order.legs);
    std::ranges::reverse(contacts);
    for (auto* lists : {&order.legs, &contacts})
      for (auto& images : *lists) std::ranges::reverse(images);
  }
  order.bounces = std::max(0, static_cast<int>(order.legs.size()) - 1);
  order.bounce = chosen_bounce(order.legs, bounce);
  const auto b = static_cast<std::size_t>(order.bounce);
  if (b > 0) order.incoming = order.legs[b - 1];
  const auto is_contact = [&](std::size_t k) { return order.bounces == 0 || k == b; };
  append(order, contacts[0], is_contact(0) ? std::optional(Leg::contact) : std::nullopt);
  for (std::size_t k = 0; k < order.legs.size(); ++k) {
    std::optional<Leg> leg;
    if (order.bounces == 0) leg = reversed ? Leg::rebound : Leg::incoming;
    if (b > 0 && k + 1 == b) leg = Leg::incoming;
    if (b > 0 && k == b) leg = Leg::rebound;
    append(order, order.legs[k], leg);
    append(order, contacts[k + 1], is_contact(k + 1) ? std::optional(Leg::contact) : std::nullopt);
  }
  for (std::size_t k = 0; k < order.sequence.size(); ++k)
    if (std::ranges::find(path.ambiguous, order.sequence[k]) != path.ambiguous.end()) order.leg[k].reset();
  return order;
}

/// Flights that differ in height by no more than places do, do not tell which came first.
int falling_heights(std::span<const PathPoint> points, const std::vector<std::vector<int>>& legs,
                    double diameter_px) {
  for (std::size_t k = 1; k < legs.size(); ++k) {
    const Top before = top_of(points, legs[k - 1], diameter_px), after = top_of(points, legs[k], diameter_px);
    const double lower = before.y - after.y;
    if (after.seen && lower > kSamePlaceOfDiameter * diameter_px) return 1;
    if (before.seen && lower < -kSamePlaceOfDiameter * diameter_px) return -1;
  }
  return 0;
}

}  // namespace strobe::digitize
