#include "host/digitize/path/straight_drop.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <utility>

#include "common/geometry/leg.hpp"
#include "common/reduction/matching/track.hpp"
#include "host/digitize/core/statistics.hpp"
#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {
namespace {

// -ln of 0.3: where flights overlap, that many images hide each other.
constexpr double kMissedCost = 1.2;
// -ln of 1 %: how rarely an outline that has passed all other checks is no ball.
constexpr double kNoBallCost = 4.6;
// Flashes from the first image of a seed to the second: two between may have none.
constexpr int kSeedFlashes = 3;
// Images of the other flight may lie between those of a seed.
constexpr std::size_t kSeedImages = 6;
constexpr int kLastImages = 4;
constexpr std::size_t kMaxImages = 64;

/// A flight towards the surface, on the time axis that it was searched on.
struct Fall {
  struct Place {
    int flash;
    double height_px;
    int image;  ///< -1: none found
  };
  std::vector<Place> places;  ///< in order of time, from the highest image to the surface
  std::uint64_t images = 0;   ///< a bit for each image seen
  double touch_s = 0.0, speed_pxps = 0.0;
  double score = 0.0;

  int seen() const { return std::popcount(images); }
};

std::uint64_t bit(int image) { return std::uint64_t{1} << static_cast<unsigned>(image); }

/// How far an image may be from where its flight has it.
double tolerance_px(double sd_px, double diameter_px) {
  return kFarthest_sd * std::hypot(sd_px, kLensOfDiameter * diameter_px);
}

/// Of an image where a flight predicts it, against one anywhere: ln of the ratio of likelihoods.
double information(std::span<const DropImage> images, const PathContext& context) {
  double highest_px = 0.0;
  for (const DropImage& image : images) highest_px = std::max(highest_px, image.height_px);
  return std::log(std::max(2.0, highest_px / (2.0 * tolerance_px(0.0, context.diameter_px))));
}

class FallSearch {
 public:
  /// `drag`: +1 where the ball falls, which drag makes slower; -1 where a rise is looked at backwards in
  /// time.
  FallSearch(std::span<const DropImage> images, const PathContext& context, std::vector<double> times_s,
             double drag)
      : images_(images),
        context_(context),
        times_s_(std::move(times_s)),
        drag_per_px_(drag * context.drag_per_m * context.ball_diameter_m / context.diameter_px) {
    for (const DropImage& image : images) highest_px_ = std::max(highest_px_, image.height_px);
    information_ = information(images, context);
  }

  std::vector<Fall> run() {
    const int flashes = static_cast<int>(times_s_.size());
    for (int i = 0; i < count(); ++i) {
      for (const int j : below(i)) {
        for (int first = 0; first + 1 < flashes; ++first)
          for (int second = first + 1; second <= std::min(flashes - 1, first + kSeedFlashes); ++second)
            try_seed({first, height(i), i}, {second, height(j), j});
      }
    }
    return std::move(falls_);
  }

 private:
  int count() const { return static_cast<int>(images_.size()); }
  double height(int i) const { return images_[static_cast<std::size_t>(i)].height_px; }
  /// The next lower images, nearest first.
  std::vector<int> below(int i) const {
    std::vector<int> lower;
    for (int j = 0; j < count(); ++j)
      if (height(j) < height(i)) lower.push_back(j);
    std::ranges::sort(lower, std::greater<>(), [this](int j) { return height(j); });
    if (lower.size() > kSeedImages) lower.resize(kSeedImages);
    return lower;
  }

  double time_s(int flash) const { return times_s_[static_cast<std::size_t>(flash)]; }

  double tolerance(int i) const {
    return tolerance_px(images_[static_cast<std::size_t>(i)].sd_px, context_.diameter_px);
  }

  /// Downwards, at a place between those of these images.
  double acceleration_pxps2(const Fall::Place& a, const Fall::Place& b) const {
    const double speed = (b.height_px - a.height_px) / (time_s(b.flash) - time_s(a.flash));
    return context_.gravity_pxps2 - drag_per_px_ * speed * speed;
  }

  /// Velocity up at `a`, if the ball flies from `a` to `b`, either of them first.
  double velocity_at(const Fall::Place& a, const Fall::Place& b) const {
    const double dt = time_s(b.flash) - time_s(a.flash);
    return (b.height_px - a.height_px) / dt + 0.5 * acceleration_pxps2(a, b) * dt;
  }

  int nearest_image(double height_px, std::uint64_t used) const {
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < count(); ++i) {
      const double off = std::abs(height(i) - height_px);
      if ((used & bit(i)) != 0 || off > tolerance(i) || off >= least) continue;
      least = off;
      nearest = i;
    }
    return nearest;
  }

  /// Where the last images lead to: few enough for the air to change little, enough for one bad one to do
  /// little.
  double predicted_px(const std::vector<Fall::Place>& places, int flash) const {
    std::vector<const Fall::Place*> last;
    for (std::size_t k = places.size(); k-- > 0 && std::ssize(last) < kLastImages;)
      if (places[k].image >= 0) last.push_back(&places[k]);
    geometry::LegFit fit(Eigen::Vector2d(0.0, -acceleration_pxps2(*last.front(), *last.back())));
    for (const Fall::Place* p : last) fit.add(time_s(p->flash), {0.0, p->height_px});
    return fit.path().position_at(time_s(flash) - fit.mean_time_s()).y();
  }

  /// On from the places in order: each flash until the ball is at the surface or above the highest image.
  void extend(std::vector<Fall::Place>& places, std::uint64_t& seen, int step) const {
    for (int flash = places.back().flash + step; flash >= 0 && flash < static_cast<int>(times_s_.size());
         flash += step) {
      const double height_px = predicted_px(places, flash);
      if (height_px < 0.5 * context_.diameter_px ||
          height_px > highest_px_ + kSamePlaceOfDiameter * context_.diameter_px)
        return;
      // At the top of its flight.
      if ((step < 0) != (height_px > places.back().height_px)) return;
      const int image = nearest_image(height_px, seen);
      if (image >= 0) seen |= bit(image);
      places.push_back({flash, image >= 0 ? height(image) : height_px, image});
    }
  }

  void try_seed(const Fall::Place& high, const Fall::Place& low) {
    if (velocity_at(low, high) >= 0.0) return;
    Fall fall;
    fall.images = bit(low.image) | bit(high.image);
    std::vector<Fall::Place> up{low, high};
    extend(up, fall.images, -1);
    while (up.back().image < 0) up.pop_back();
    fall.places.assign(up.rbegin(), up.rend());
    fill_between(fall.places);
    extend(fall.places, fall.images, 1);
    finish(std::move(fall));
  }

  /// Flashes between the two images of the seed.
  void fill_between(std::vector<Fall::Place>& places) const {
    const Fall::Place low = places.back(), high = places[places.size() - 2];
    const double velocity = velocity_at(low, high), acceleration = acceleration_pxps2(low, high);
    places.pop_back();
    for (int flash = high.flash + 1; flash < low.flash; ++flash) {
      const double dt = time_s(flash) - time_s(low.flash);
      places.push_back({flash, low.height_px + velocity * dt - 0.5 * acceleration * dt * dt, -1});
    }
    places.push_back(low);
  }

  void finish(Fall fall) {
    const auto first = std::ranges::find_if(fall.places, [](const Fall::Place& p) { return p.image >= 0; });
    const auto lowest = std::ranges::find_if(fall.places.rbegin(), fall.places.rend(),
                                             [](const Fall::Place& p) { return p.image >= 0; });
    geometry::LegFit fit(Eigen::Vector2d(0.0, -acceleration_pxps2(*first, *lowest)));
    for (const Fall::Place& p : fall.places)
      if (p.image >= 0) fit.add(time_s(p.flash), {0.0, p.height_px});
    const double nearest_s = time_s(lowest->flash);
    const auto touch = geometry::crossing(fit, 0.5 * context_.diameter_px, nearest_s);
    if (!touch || !(touch->velocity.y() < 0.0)) return;
    fall.speed_pxps = -touch->velocity.y();
    fall.touch_s = touch->time_s;
    // Two images fix a flight.
    const int missed = static_cast<int>(fall.places.size()) - fall.seen();
    fall.score = information_ * (fall.seen() - 2) + kNoBallCost * fall.seen() - kMissedCost * missed;
    if (fall.score < 0.0) return;
    if (known_.emplace(fall.images, fall.places.front().flash).second) falls_.push_back(std::move(fall));
  }

  std::span<const DropImage> images_;
  const PathContext& context_;
  std::vector<double> times_s_;
  double drag_per_px_;
  double highest_px_ = 0.0;
  double information_ = 1.0;
  std::set<std::pair<std::uint64_t, int>> known_;  ///< images and the first one's flash
  std::vector<Fall> falls_;
};

/// A rise is a fall on the reversed time axis.
std::vector<double> reversed(std::span<const double> times_s) {
  std::vector<double> result;
  for (std::size_t k = times_s.size(); k-- > 0;) result.push_back(-times_s[k]);
  return result;
}

struct Pair {
  const Fall* down = nullptr;
  const Fall* up = nullptr;
  double score = 0.0;

  bool bounces() const { return down != nullptr && up != nullptr; }
  bool same_numbers(const Pair& other) const { return same(down, other.down) && same(up, other.up); }

 private:
  static bool same(const Fall* a, const Fall* b) {
    if (a == nullptr || b == nullptr) return a == b;
    return std::abs(a->speed_pxps - b->speed_pxps) <= kSameSpeed * a->speed_pxps;
  }
};

/// `information` is an image's; images that both flights claim are explained once. Touchdown and lift-off are
/// known to a place.
std::vector<Pair> pairs_of(const std::vector<Fall>& downs, const std::vector<Fall>& ups, double information,
                           const PathContext& context) {
  const auto dwell = matching::DwellLimits::of_diameter(context.ball_diameter_m);
  std::vector<Pair> pairs;
  for (const Fall& up : ups) pairs.push_back({nullptr, &up, up.score});
  std::vector<const Fall*> by_lift;
  for (const Fall& up : ups) by_lift.push_back(&up);
  std::ranges::sort(by_lift, {}, [](const Fall* up) { return -up->touch_s; });
  for (const Fall& down : downs) {
    pairs.push_back({&down, nullptr, down.score});
    const double slack_s = kSamePlaceOfDiameter * context.diameter_px / down.speed_pxps;
    const double earliest = down.touch_s + dwell.least_s - slack_s;
    const double latest = down.touch_s + dwell.most_s + slack_s;
    auto up = std::ranges::lower_bound(by_lift, earliest, {}, [](const Fall* f) { return -f->touch_s; });
    for (; up != by_lift.end() && -(*up)->touch_s <= latest; ++up) {
      if ((*up)->speed_pxps > (1.0 + kSameSpeed) * down.speed_pxps) continue;  // a bounce adds no energy
      const int shared = std::popcount(down.images & (*up)->images);
      pairs.push_back({&down, *up, down.score + (*up)->score - shared * (information + kNoBallCost)});
    }
  }
  return pairs;
}

/// The likeliest pair, if it is clearly likelier than any of other numbers: flights of the same speed are
/// one, seen through one image more or less.
std::optional<Pair> likeliest(const std::vector<Pair>& pairs) {
  if (pairs.empty()) return std::nullopt;
  const Pair best = *std::ranges::max_element(pairs, {}, &Pair::score);
  for (const Pair& pair : pairs)
    if (!pair.same_numbers(best) && best.score - pair.score < kThousandToOne) return std::nullopt;
  return best;
}

/// Images of a flight, less those at a place where the other flight's is not told apart.
StraightDrop::Flight flight_of(const Fall& fall, const Fall& other, double diameter_px,
                               std::vector<int>& doubled) {
  StraightDrop::Flight flight;
  flight.touch_s = fall.touch_s;
  flight.speed_pxps = fall.speed_pxps;
  for (const Fall::Place& p : fall.places) {
    if (p.image < 0) continue;
    const bool both = std::ranges::any_of(other.places, [&](const Fall::Place& q) {
      const bool apart = q.image >= 0 && q.image != p.image;
      return !apart && std::abs(q.height_px - p.height_px) < kSamePlaceOfDiameter * diameter_px;
    });
    if (both) {
      doubled.push_back(p.image);
      continue;
    }
    flight.image.push_back(p.image);
    flight.flash.push_back(p.flash);
  }
  return flight;
}

StraightDrop drop_of(const Pair& best, int flashes, double diameter_px) {
  StraightDrop drop;
  drop.down = flight_of(*best.down, *best.up, diameter_px, drop.doubled);
  drop.up = flight_of(*best.up, *best.down, diameter_px, drop.doubled);
  std::ranges::sort(drop.doubled);
  drop.doubled.erase(std::unique(drop.doubled.begin(), drop.doubled.end()), drop.doubled.end());
  std::ranges::reverse(drop.up.image);
  std::ranges::reverse(drop.up.flash);
  for (int& flash : drop.up.flash) flash = flashes - 1 - flash;
  drop.up.touch_s = -drop.up.touch_s;
  return drop;
}

}  // namespace

std::optional<StraightDrop> split_drop(std::span<const DropImage> images, const PathContext& context) {
  if (images.size() < 4 || images.size() > kMaxImages || context.flash_times_s.size() < 4)
    return std::nullopt;
  const std::vector<double> times(context.flash_times_s.begin(), context.flash_times_s.end());
  const std::vector<Fall> downs = FallSearch(images, context, times, 1.0).run();
  const std::vector<Fall> ups = FallSearch(images, context, reversed(times), -1.0).run();
  const std::vector<Pair> pairs = pairs_of(downs, ups, information(images, context), context);
  const auto best = likeliest(pairs);
  if (!best || !best->bounces()) return std::nullopt;
  StraightDrop drop = drop_of(*best, static_cast<int>(times.size()), context.diameter_px);
  if (drop.down.image.size() < 2 || drop.up.image.size() < 2) return std::nullopt;
  for (const DropImage& image : images) {
    double off = std::numeric_limits<double>::infinity();
    for (const Fall* fall : {best->down, best->up})
      for (const Fall::Place& p : fall->places) off = std::min(off, std::abs(p.height_px - image.height_px));
    drop.off_px.push_back(off);
  }
  return drop;
}

namespace {

void take_flight(const StraightDrop::Flight& flight, const std::vector<int>& images, Path& path) {
  std::vector<int>& leg = path.legs.emplace_back();
  for (std::size_t k = 0; k < flight.image.size(); ++k) {
    leg.push_back(images[static_cast<std::size_t>(flight.image[k])]);
    path.flash[static_cast<std::size_t>(leg.back())] = flight.flash[k];
  }
}

}  // namespace

void take_drop_images(std::span<const PathPoint> points, std::vector<int> images, const PathContext& context,
                      Path& path) {
  std::vector<DropImage> heights;
  for (const int i : images) {
    const PathPoint& p = points[static_cast<std::size_t>(i)];
    heights.push_back({p.at.y, p.sd_px});
  }
  path.straight = true;
  path.ambiguous.clear();
  const auto drop = split_drop(heights, context);
  if (!drop) {
    path.legs = {std::move(images)};
    return;
  }
  path.legs.clear();
  path.flash.assign(points.size(), -1);
  take_flight(drop->down, images, path);
  take_flight(drop->up, images, path);
  for (std::size_t k = 0; k < images.size(); ++k) {
    if (path.flash[static_cast<std::size_t>(images[k])] >= 0) continue;
    const bool doubled = std::ranges::find(drop->doubled, static_cast<int>(k)) != drop->doubled.end();
    path.outliers.push_back({images[k], false, doubled, drop->off_px[k]});
  }
}

}  // namespace strobe::digitize
