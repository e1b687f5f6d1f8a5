#include "host/digitize/path/path.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>

#include "common/flight/gravity.hpp"
#include "host/digitize/core/ball.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/flight_legs.hpp"
#include "host/digitize/path/leg_line.hpp"
#include "host/digitize/path/straight_drop.hpp"

namespace strobe::digitize {

double variance_across(const PathPoint& point, double diameter_px) {
  const double lens = kLensOfDiameter * diameter_px;
  return point.sd_px * point.sd_px + lens * lens;
}

std::vector<PathPoint> path_points(std::span<const Outline> outlines,
                                   const std::optional<SurfaceLine>& surface) {
  const geometry::SurfaceFrame axes = surface ? surface_frame(*surface) : geometry::SurfaceFrame{};
  std::vector<PathPoint> points;
  points.reserve(outlines.size());
  for (const Outline& o : outlines) {
    const double sd = std::hypot(o.centre_sd(), o.moved_centre_px() / kFarthest_sd);
    points.push_back(
        {to_point(axes.from_image(to_eigen(o.centre))), sd, std::clamp(o.probability, 0.0, 1.0)});
  }
  return points;
}

PathContext path_context(std::span<const Outline> outlines, const std::optional<SurfaceLine>& surface,
                         const FlightFacts& facts) {
  std::vector<double> diameters;
  for (const Outline& o : outlines) diameters.push_back(o.diameter);
  PathContext context{median(std::move(diameters)), surface.has_value(),
                      surface ? height_sd_px(*surface) : 0.0};
  context.flash_times_s = facts.times_s();
  context.ball_diameter_m = facts.ball_diameter_m;
  context.drag_per_m = facts.drag_per_m;
  context.gravity_pxps2 = flight::kStandardGravity_mps2 * context.diameter_px / facts.ball_diameter_m;
  return context;
}

bool touches(double height_px, double sd_px, const PathContext& context) {
  if (!context.surface_known) return false;
  return height_px <
         0.5 * context.diameter_px - std::max(kFarthest_sd * std::hypot(sd_px, context.surface_sd_px),
                                              kLensOfDiameter * context.diameter_px);
}

namespace {

constexpr std::size_t kMaxLegLines = 80;

class Finder {
 public:
  Finder(std::span<const PathPoint> points, const PathContext& context)
      : points_(points), context_(context), d_(context.diameter_px) {}

  Path run() {
    sort_by_height();
    kept_ = choose_legs(points_, airborne_, leg_lines(points_, airborne_, d_, kMaxLegLines), context_);
    share_images();
    place_contacts();
    if (legs_[1].empty()) lone_leg();
    order_legs();
    take_legs();
    take_curves();
    take_drop();
    release_doubtful();
    list_outliers();
    return std::move(path_);
  }

 private:
  void sort_by_height() {
    for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
      const PathPoint& p = point_at(points_, i);
      if (!context_.surface_known) {
        airborne_.push_back(i);
      } else if (p.at.y <
                 0.5 * d_ * (1.0 - kMaxCompressionOfRadius) - kFarthest_sd * context_.surface_sd_px) {
        path_.outliers.push_back({i, true, false, 0.0});
      } else if (touches(p.at.y, p.sd_px, context_)) {
        low_.push_back(i);
      } else {
        airborne_.push_back(i);
      }
    }
  }

  /// An image on both lines is the nearer one's.
  void share_images() {
    if (kept_.empty()) {
      take_best_alone();
      return;
    }
    const LegLine& one = kept_.front();
    if (kept_.size() == 1) {
      legs_[0] = one.members;
      return;
    }
    const LegLine& two = kept_.back();
    for (const int i : one.members) {
      const bool both = std::binary_search(two.members.begin(), two.members.end(), i);
      const bool second =
          both && std::abs(two.off(point_at(points_, i).at)) < std::abs(one.off(point_at(points_, i).at));
      legs_[second ? 1 : 0].push_back(i);
    }
    for (const int i : two.members) {
      if (!std::binary_search(one.members.begin(), one.members.end(), i)) legs_[1].push_back(i);
    }
    list_ambiguous(one, two);
  }

  void take_best_alone() {
    if (airborne_.empty()) return;
    legs_[0] = {*std::max_element(airborne_.begin(), airborne_.end(), [this](int a, int b) {
      return point_at(points_, a).weight < point_at(points_, b).weight;
    })};
  }

  /// A line through two images passes through both whatever they are: the other leg's image is on it too.
  void list_ambiguous(const LegLine& one, const LegLine& two) {
    std::vector<int> both;
    std::ranges::set_intersection(one.members, two.members, std::back_inserter(both));
    const std::size_t fewest = std::min(one.members.size(), two.members.size()) - both.size();
    if (fewest < kMinOwnImages) path_.ambiguous = both;
  }

  /// Low images between the two crossings, or near the one.
  void place_contacts() {
    std::optional<double> from, to;
    for (const LegLine& line : kept_) {
      if (const auto c = crossing(line, d_)) {
        from = std::min(from.value_or(c->x), c->x);
        to = std::max(to.value_or(c->x), c->x);
      }
    }
    const double margin = kept_.size() == 2 ? kBounceNoise * d_ : kLongestContact * d_;
    for (const int i : low_) {
      const double x = point_at(points_, i).at.x;
      if (!from || (x >= *from - margin && x <= *to + margin)) path_.contact.push_back(i);
    }
    std::sort(path_.contact.begin(), path_.contact.end(),
              [this](int a, int b) { return point_at(points_, a).at.x < point_at(points_, b).at.x; });
  }

  /// A leg of one image: beyond where the other leg meets the surface, or beyond the images in contact.
  void lone_leg() {
    if (!context_.surface_known || legs_[0].empty()) return;
    if (!path_.contact.empty() && legs_[0].size() == 2 && split_at_contact()) return;
    if (kept_.empty()) return;
    const auto c = crossing(kept_.front(), d_);
    if (!c) return;
    const cv::Point2d touch(c->x, 0.5 * d_);
    double longest = 0.0;
    const cv::Point2d end = far_end(points_, kept_.front(), touch);
    longest = cv::norm(end - touch) / static_cast<double>(legs_[0].size());
    std::vector<int> found;
    for (const int i : airborne_) {
      if (member(i) || point_at(points_, i).weight <= leg_cost(context_)) continue;
      const cv::Point2d from = point_at(points_, i).at - touch;
      if (cv::norm(from) <= kLongestContact * d_ + longest && from.x * c->side <= 0.0) found.push_back(i);
    }
    if (found.size() == 1) legs_[1] = found;
  }

  bool split_at_contact() {
    const int a = legs_[0][0], b = legs_[0][1];
    const double x = point_at(points_, path_.contact.front()).at.x;
    if ((point_at(points_, a).at.x - x) * (point_at(points_, b).at.x - x) >= 0.0) return false;
    legs_ = {std::vector<int>{a}, std::vector<int>{b}};
    return true;
  }

  bool member(int i) const {
    for (const auto& leg : path_.legs) {
      if (std::find(leg.begin(), leg.end(), i) != leg.end()) return true;
    }
    for (const auto& leg : legs_) {
      if (std::find(leg.begin(), leg.end(), i) != leg.end()) return true;
    }
    return std::find(path_.contact.begin(), path_.contact.end(), i) != path_.contact.end();
  }

  void order_legs() {
    for (std::size_t k = 0; k < 2; ++k) {
      std::vector<int>& leg = legs_[k];
      if (leg.size() < 2) continue;
      cv::Point2d down(0.0, -1.0);
      if (k < kept_.size()) down = kept_[k].along.y < 0 ? kept_[k].along : -kept_[k].along;
      std::sort(leg.begin(), leg.end(), [&](int a, int b) {
        return point_at(points_, a).at.dot(down) < point_at(points_, b).at.dot(down);
      });
    }
  }

  /// Along the path: from far to the surface and up again.
  void take_legs() {
    for (auto& leg : legs_) {
      if (leg.empty()) continue;
      if (!path_.legs.empty()) std::reverse(leg.begin(), leg.end());
      path_.legs.push_back(std::move(leg));
      leg.clear();
    }
  }

  double weight(const std::vector<int>& members) const {
    double sum = 0.0;
    for (const int i : members) sum += point_at(points_, i).weight;
    return sum;
  }

  /// Legs of free flight that leave less unexplained take the place of the straight ones.
  void take_curves() {
    double taken = 0.0;
    for (const auto& leg : path_.legs) taken += weight(leg);
    const double cost = leg_cost(context_);
    if (weight(airborne_) <= taken + cost) return;
    const std::vector<FlightLeg> flights = flight_legs(points_, airborne_, context_);
    double explained = -cost;
    for (const FlightLeg& flight : flights) explained += flight.weight - cost;
    if (explained <= taken - cost * static_cast<double>(path_.legs.size())) return;
    path_.legs.clear();
    path_.contact.clear();
    path_.ambiguous.clear();
    path_.curved = true;
    for (const FlightLeg& flight : flights) {
      path_.legs.push_back(flight.members);
      curves_.push_back(flight.curve);
    }
    place_curve_contacts();
  }

  /// Low images near the end of a leg.
  void place_curve_contacts() {
    for (const int i : low_) {
      const bool near = std::ranges::any_of(path_.legs, [&](const std::vector<int>& leg) {
        return std::min(std::abs(point_at(points_, i).at.x - point_at(points_, leg.front()).at.x),
                        std::abs(point_at(points_, i).at.x - point_at(points_, leg.back()).at.x)) <=
               kLongestContact * d_;
      });
      if (near) path_.contact.push_back(i);
    }
    std::ranges::sort(path_.contact, {}, [this](int i) { return point_at(points_, i).at.x; });
  }

  /// The images of a ball that goes straight down and up, along the normal and in one band: only times tell
  /// its legs. Empty if their places do.
  std::vector<int> images_on_one_line() const {
    if (!context_.surface_known || path_.curved || kept_.empty()) return {};
    const LegLine& line = kept_.front();
    if (std::abs(line.along.x) > kSameDirection) return {};
    const auto on_line = [&](int i) {
      return std::abs(line.off(point_at(points_, i).at)) <= kBandOfDiameter * d_;
    };
    for (const auto& leg : path_.legs)
      if (!std::ranges::all_of(leg, on_line)) return {};
    std::vector<int> images;
    std::ranges::copy_if(airborne_, std::back_inserter(images), on_line);
    std::ranges::sort(images, std::greater<>(), [this](int i) { return point_at(points_, i).at.y; });
    return images;
  }

  void take_drop() {
    std::vector<int> images = images_on_one_line();
    if (images.size() >= 2) take_drop_images(points_, std::move(images), context_, path_);
  }

  /// Of straight legs the images at the surface that may be pressed, by as much as its height is not known:
  /// an image more or less near the surface is worth less to a leg than one in contact does harm.
  void release_doubtful() {
    if (!context_.surface_known || path_.curved || path_.straight) return;
    const double flies = 0.5 * d_ * (1.0 - kFliesOfRadius) + kDoubtful_sd * context_.surface_sd_px;
    for (std::size_t k = 0; k < path_.legs.size(); ++k) {
      std::vector<int>& leg = path_.legs[k];
      const auto lowest = [&] { return k == 0 ? std::prev(leg.end()) : leg.begin(); };
      while (leg.size() > kMinOwnImages + 1 && point_at(points_, *lowest()).at.y < flies) {
        path_.contact.push_back(*lowest());
        std::erase(path_.ambiguous, *lowest());
        leg.erase(lowest());
      }
    }
    std::ranges::sort(path_.contact, {}, [this](int i) { return point_at(points_, i).at.x; });
  }

  void list_outliers() {
    for (int i = 0; i < static_cast<int>(points_.size()); ++i) {
      const bool listed = std::any_of(path_.outliers.begin(), path_.outliers.end(),
                                      [i](const Path::Outlier& outlier) { return outlier.index == i; });
      if (listed || member(i)) continue;
      double off = std::numeric_limits<double>::infinity();
      if (!path_.curved)
        for (const LegLine& line : kept_) off = std::min(off, std::abs(line.off(point_at(points_, i).at)));
      for (const FlightCurve& curve : curves_)
        off = std::min(off, std::abs(curve.off(point_at(points_, i).at)));
      path_.outliers.push_back({i, false, false, off});
    }
  }

  std::span<const PathPoint> points_;
  const PathContext& context_;
  double d_;
  std::vector<int> airborne_, low_;
  std::array<std::vector<int>, 2> legs_;  ///< from far to the surface
  std::vector<LegLine> kept_;
  std::vector<FlightCurve> curves_;
  Path path_;
};

/// Whether each of the points is in exactly one list.
bool is_partition(const Path& path, std::size_t points) {
  std::vector<int> count(points, 0);
  const auto add = [&](int i) { ++count.at(static_cast<std::size_t>(i)); };
  for (const auto& leg : path.legs) std::ranges::for_each(leg, add);
  std::ranges::for_each(path.contact, add);
  for (const Path::Outlier& outlier : path.outliers) add(outlier.index);
  return std::ranges::all_of(count, [](int n) { return n == 1; });
}

}  // namespace

Path find_path(std::span<const PathPoint> points, const PathContext& context) {
  Path path = Finder(points, context).run();
  assert(is_partition(path, points.size()));
  return path;
}

}  // namespace strobe::digitize
