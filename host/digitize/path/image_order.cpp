#include "host/digitize/path/image_order.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "common/flight/parabola.hpp"
#include "common/geometry/leg.hpp"
#include "common/reduction/matching/flash_match.hpp"
#include "common/units/angles.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/flight_legs.hpp"
#include "host/digitize/path/path_order.hpp"

namespace strobe::digitize {
namespace {

using reduction::Leg;

const PathPoint& at(std::span<const PathPoint> points, int i) { return points[static_cast<std::size_t>(i)]; }

constexpr const char* kUndecidedDrop =
    "the ball flies along one line, and the flashes' times leave open which images are of the way down and "
    "which of "
    "the way up: no image has a time; steps of one to two diameters from flash to flash tell (plan: "
    "drop_height_m)";

/// Median of the steps in height from image to image.
double step_up(std::span<const PathPoint> points, const std::vector<int>& leg) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < leg.size(); ++k)
    steps.push_back(std::abs(at(points, leg[k]).at.y - at(points, leg[k - 1]).at.y));
  return median(std::move(steps));
}

struct Timed {
  matching::FlashMatch match;
  double degrees_of_freedom = 0.0;  ///< of the flight, see common/reduction/matching/flash_match.hpp
  double speed_in = 0.0;            ///< along the normal, px/s, > 0; 0: not known
};

class Orderer {
 public:
  Orderer(std::span<const PathPoint> points, const Path& path, const TimeContext& context)
      : points_(points), path_(path), context_(context) {}

  TimeOrder run() {
    if (path_.undecided()) {
      order_undecided();
      return std::move(result_);
    }
    PathOrder right = path_order(points_, path_, false, context_.bounce);
    PathOrder left = path_order(points_, path_, true, context_.bounce);
    if (right.towards < 0.0) std::swap(right, left);
    if (path_.straight) {
      take(path_order(points_, path_, false, context_.bounce));
    } else if (context_.leftwards) {
      take(*context_.leftwards ? left : right);
    } else if (!path_.bounces()) {
      order_one_leg(right, left);
    } else if (path_.curved) {
      order_flights(right, left);
    } else {
      order_bounce(right, left);
    }
    return std::move(result_);
  }

 private:
  matching::Track track(const PathOrder& order) const {
    matching::Track track;
    track.radius_px = 0.5 * context_.path.diameter_px;
    track.px_per_m = context_.px_per_m;
    track.surface_known = context_.path.surface_known;
    track.gravity_pxps2 = {order.towards * context_.gravity_mps2.x() * context_.px_per_m,
                           context_.gravity_mps2.y() * context_.px_per_m};
    track.air.drag_per_m = context_.path.drag_per_m;
    double variance = 0.0;
    for (std::size_t k = 0; k < order.sequence.size(); ++k) {
      if (!order.leg[k]) continue;
      const PathPoint& p = at(points_, order.sequence[k]);
      track.images.push_back({*order.leg[k], {order.towards * p.at.x, p.at.y}});
      variance += p.sd_px * p.sd_px;
    }
    variance /= static_cast<double>(track.images.size());
    track.sd_px = std::max(kMinResidual_px, std::sqrt(variance));
    if (path_.straight) matching::allow_for_drop(track);
    return track;
  }

  std::optional<Timed> timed(const PathOrder& order) const {
    if (context_.path.flash_times_s.empty()) return std::nullopt;
    const matching::Track path = track(order);
    const auto match = matching::match_flashes(context_.path.flash_times_s, path, std::nullopt);
    if (!match) return std::nullopt;
    return Timed{*match, matching::degrees_of_freedom(path),
                 speed(path, match->hypotheses.front().flash, Leg::incoming)};
  }

  double speed(const matching::Track& path, const std::vector<int>& flash, Leg leg) const {
    geometry::LegFit fit(path.gravity_pxps2);
    double nearest_s = 0.0;
    for (std::size_t k = 0; k < path.images.size(); ++k) {
      if (path.images[k].leg != leg) continue;
      const double time_s = context_.path.flash_times_s[static_cast<std::size_t>(flash[k])];
      if (leg == Leg::incoming || fit.count() == 0) nearest_s = time_s;
      fit.add(time_s, path.images[k].centre_px);
    }
    if (!fit.has_velocity()) return 0.0;
    const auto at = path.surface_known ? geometry::crossing(fit, path.radius_px, nearest_s)
                                       : std::optional<geometry::Crossing>();
    return std::abs(at ? at->velocity.y() : fit.path().velocity.y());
  }

  /// +1 where a is more likely than b, -1 the other way round, 0 where the flashes do not tell.
  static int likelier(const Timed& a, const Timed& b) {
    if (a.match.steady != b.match.steady) return a.match.steady ? 1 : -1;
    const double freedom = std::max(1.0, a.degrees_of_freedom);
    const double scale = std::max(1.0, std::min(a.match.chi_squared, b.match.chi_squared) / freedom);
    const double difference = (a.match.chi_squared - b.match.chi_squared) / scale;
    if (0.5 * std::abs(difference) > kThousandToOne) return difference < 0.0 ? 1 : -1;
    return 0;
  }

  void order_bounce(const PathOrder& right, const PathOrder& left) {
    const auto tr = timed(right), tl = timed(left);
    double in_right = step_up(points_, right.incoming), in_left = step_up(points_, left.incoming);
    if (tr && tl) {
      if (const int sign = likelier(*tr, *tl)) return sign > 0 ? take(right, tr) : take(left, tl);
      if (tr->speed_in > 0.0 && tl->speed_in > 0.0) {
        in_right = tr->speed_in;
        in_left = tl->speed_in;
      }
    }
    const double difference = in_right - in_left;
    if (in_right <= 0.0 || in_left <= 0.0 ||
        std::abs(difference) < 2.0 * kSameSpeed * std::max(in_right, in_left)) {
      result_.remarks.push_back("the two legs do not tell the direction of travel: taken to be to the right");
      return take(right, tr);
    }
    difference > 0.0 ? take(right, tr) : take(left, tl);
  }

  /// A bounce adds no energy: the ball flies less high after it.
  void order_flights(const PathOrder& right, const PathOrder& left) {
    const int falls = falling_heights(points_, right.legs, context_.path.diameter_px);
    if (falls == 0)
      result_.remarks.push_back(
          "the bounces' heights do not tell the direction of travel: taken to be to the right");
    take(falls >= 0 ? right : left);
  }

  void order_one_leg(const PathOrder& right, const PathOrder& left) {
    const auto tr = timed(right), tl = timed(left);
    if (tr && tl) {
      if (const int sign = likelier(*tr, *tl)) return sign > 0 ? take(right, tr) : take(left, tl);
    }
    if (right.sequence.size() > 1)
      result_.remarks.push_back("one leg does not tell the direction of travel: taken to be to the right");
    take(right, tr);
  }

  /// `match`: the order's, if it was made already.
  void take(const PathOrder& order, std::optional<Timed> match = std::nullopt) {
    result_.sequence = order.sequence;
    result_.leftwards = order.towards < 0.0;
    const bool said = context_.path.surface_known || path_.bounces();
    for (const auto& leg : order.leg) {
      result_.leg.push_back(said ? leg : std::nullopt);
      result_.other_leg.push_back(!leg.has_value());
    }
    tell_bounces(order);
    if (path_.straight) return set_drop_times(order);
    if (context_.path.flash_times_s.empty()) return;
    if (!match) match = timed(order);
    if (!match) {
      result_.remarks.push_back(fmt::format("{} images, but only {} flashes: no image has a time",
                                            order.sequence.size(), context_.path.flash_times_s.size()));
      return;
    }
    const matching::Track path = track(order);
    if (!matching::is_steady(path, match->match)) {
      const double off = matching::off_steady_px(path, match->match);
      result_.remarks.push_back(
          "no steady flight passes through the images" +
          (std::isfinite(off) ? fmt::format(" (they are {:.0f} px off)", off) : std::string()) +
          ": no image has a time");
      return;
    }
    set_flashes(order, match->match.hypotheses.front().flash);
    if (!matching::gaps_agree(match->match))
      result_.remarks.push_back("which flash made which image is ambiguous");
  }

  /// Straight down and up: by height, no image is of any leg.
  void order_undecided() {
    const PathOrder order = path_order(points_, path_, false, std::nullopt);
    result_.sequence = order.sequence;
    result_.leg.resize(order.sequence.size());
    result_.other_leg.assign(order.sequence.size(), true);
    result_.remarks.push_back(context_.path.flash_times_s.empty()
                                  ? "the ball flies along one line: without the flashes' times no image can "
                                    "be told to be of the way down "
                                    "or of the way up"
                                  : kUndecidedDrop);
  }

  /// By the match of both legs, which weighs residuals. It must see the same steps as the search for the
  /// flights.
  void set_drop_times(const PathOrder& order) {
    const auto match = timed(order);
    const std::vector<bool> other_leg = result_.other_leg;
    set_drop_flashes(order);
    if (!match || !match->match.steady) return;
    const TimeOrder found = result_;
    result_.other_leg = other_leg;
    result_.flash.clear();
    set_flashes(order, match->match.hypotheses.front().flash);
    int first = -1, shift = 0;
    for (std::size_t k = 0; k < found.flash.size(); ++k) {
      const bool airborne = order.leg[k] && order.leg[k] != Leg::contact && found.flash[k] >= 0;
      if (!airborne) continue;
      if (first < 0) shift = result_.flash[k] - found.flash[k];
      first = 0;
      if (result_.flash[k] - found.flash[k] == shift) continue;
      result_.flash.assign(order.sequence.size(), -1);
      result_.leg.assign(order.sequence.size(), std::nullopt);
      result_.other_leg.assign(order.sequence.size(), true);
      result_.remarks.push_back(kUndecidedDrop);
      return;
    }
  }

  /// Each image's, and those of contacts where as many flashes lie between.
  void set_drop_flashes(const PathOrder& order) {
    for (const int i : order.sequence) result_.flash.push_back(path_.flash[static_cast<std::size_t>(i)]);
    const auto first = std::ranges::find(order.leg, std::optional(Leg::contact));
    const auto count = std::ranges::count(order.leg, std::optional(Leg::contact));
    const auto at = first - order.leg.begin();
    const auto flash = [&](std::ptrdiff_t k) -> int& { return result_.flash[static_cast<std::size_t>(k)]; };
    const bool determined = count > 0 && flash(at + count) - flash(at - 1) == static_cast<int>(count) + 1;
    for (std::ptrdiff_t k = at; determined && k < at + count; ++k) flash(k) = flash(k - 1) + 1;
    for (std::size_t k = 0; k < result_.flash.size(); ++k)
      result_.other_leg[k] = result_.other_leg[k] || result_.flash[k] < 0;
  }

  void tell_bounces(const PathOrder& order) {
    if (!path_.ambiguous.empty())
      result_.remarks.push_back(
          "an image lies on either leg, and too few others tell which: it has no leg and no time");
    if (order.bounces < 2) return;
    result_.remarks.push_back(
        fmt::format("the ball bounces {} times: legs and times are those of bounce {}, counted in time",
                    order.bounces, order.bounce));
  }

  void set_flashes(const PathOrder& order, const std::vector<int>& flash) {
    auto next = flash.begin();
    for (const auto& leg : order.leg) result_.flash.push_back(leg ? *next++ : -1);
  }

  std::span<const PathPoint> points_;
  const Path& path_;
  const TimeContext& context_;
  TimeOrder result_;
};

}  // namespace

TimeOrder order_in_time(std::span<const PathPoint> points, const Path& path, const TimeContext& context) {
  return Orderer(points, path, context).run();
}

namespace {

using reduction::BallImage;
using reduction::Frame;
using reduction::Leg;

/// Images added by hand are kept whether or not they lie on the path.
void assign_outliers(Path& path, std::span<const PathPoint> points, const PathContext& context) {
  for (const Path::Outlier& outlier : path.outliers) {
    const PathPoint& p = points[static_cast<std::size_t>(outlier.index)];
    if (touches(p.at.y, p.sd_px, context)) {
      path.contact.push_back(outlier.index);
      continue;
    }
    std::vector<int>* nearest = nullptr;
    double least = std::numeric_limits<double>::infinity();
    for (auto& leg : path.legs) {
      for (const int i : leg) {
        const double distance = cv::norm(points[static_cast<std::size_t>(i)].at - p.at);
        if (distance >= least) continue;
        least = distance;
        nearest = &leg;
      }
    }
    if (nearest == nullptr) nearest = &path.legs.emplace_back();
    nearest->push_back(outlier.index);
  }
  const auto at = [&](int i) { return points[static_cast<std::size_t>(i)].at; };
  for (std::size_t k = 0; k < path.legs.size(); ++k) {
    // Along the path: from left to right, or down and up again.
    const auto place = [&](int i) { return path.curved ? at(i).x : k == 0 ? -at(i).y : at(i).y; };
    std::ranges::stable_sort(path.legs[k], {}, place);
  }
  std::ranges::stable_sort(path.contact, {}, [&](int i) { return at(i).x; });
  path.outliers.clear();
}

template <typename T>
std::vector<T> permuted(std::vector<T>& values, const std::vector<int>& sequence) {
  std::vector<T> result;
  result.reserve(values.size());
  for (const int i : sequence) result.push_back(std::move(values[static_cast<std::size_t>(i)]));
  return result;
}

void set_legs_and_times(const TimeOrder& order, std::span<const double> times_s, Frame& frame) {
  for (std::size_t k = 0; k < frame.images.size(); ++k) {
    BallImage& image = frame.images[k];
    image.other_leg = order.other_leg[k];
    if (!image.leg && !image.other_leg) image.leg = order.leg[k];
    image.time_s = std::numeric_limits<double>::quiet_NaN();
    image.flash_index.reset();
    if (order.flash.empty() || order.flash[k] < 0) continue;
    image.flash_index = order.flash[k];
    image.time_s = times_s[static_cast<std::size_t>(order.flash[k])];
  }
}

}  // namespace

std::optional<SurfaceLine> surface_line_of(const Frame& frame) {
  if (frame.surface_px.size() < 2) return std::nullopt;
  SurfaceLine line;
  line.sd_px = frame.surface_sd_px.value_or(0.0);
  for (const auto& p : frame.surface_px) line.points.emplace_back(p.x, p.y);
  return line;
}

void order_images(Frame& frame, std::vector<Outline>& outlines, const FlightFacts& facts,
                  std::vector<std::string>& remarks) {
  if (outlines.size() != frame.images.size() || outlines.empty()) return;
  const auto surface = surface_line_of(frame);
  const auto points = path_points(outlines, surface);
  TimeContext context;
  context.path = path_context(outlines, surface, facts);
  context.px_per_m = context.path.diameter_px / facts.ball_diameter_m;
  context.gravity_mps2 = flight::gravity_mps2(radians(frame.surface_angle_deg));
  context.leftwards = facts.leftwards;
  context.bounce = facts.bounce;
  Path path = find_path(points, context.path);
  if (!path.outliers.empty()) assign_outliers(path, points, context.path);
  TimeOrder order = order_in_time(points, path, context);
  assert(order.sequence.size() == outlines.size());
  frame.images = permuted(frame.images, order.sequence);
  outlines = permuted(outlines, order.sequence);
  set_legs_and_times(order, facts.times_s(), frame);
  remarks.insert(remarks.end(), order.remarks.begin(), order.remarks.end());
}

}  // namespace strobe::digitize
