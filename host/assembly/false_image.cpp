#include "host/assembly/false_image.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace strobe::host {
namespace {

constexpr std::ptrdiff_t kFewestLeft = 3;  // of a leg: two have no residual
// Of the interval: a velocity changes by as little.
constexpr double kSameShare = 0.005;

Track without(const Track& track, std::size_t image) {
  Track others = track;
  others.images.erase(others.images.begin() + static_cast<std::ptrdiff_t>(image));
  return others;
}

bool is_airborne(const TrackPoint& image) { return image.leg != Leg::contact; }

bool can_be_left_out(const Track& track, std::size_t image) {
  const Leg leg = track.images[image].leg;
  return leg == Leg::contact || std::ranges::count(track.images, leg, &TrackPoint::leg) > kFewestLeft;
}

/// -2 ln of the likelihood, less what noise alone makes of it: so that one of fewer images in the air is not preferred.
double beyond_expected(const Track& track, const FlashMatch& match) {
  const auto airborne = std::ranges::count_if(track.images, is_airborne);
  return match.chi_squared + match.penalty - 2.0 * static_cast<double>(airborne);
}

/// Whether the images but this one are of flashes at the same times after the first, as those of an even train are but
/// for microseconds.
bool is_as_before(std::span<const double> times_s, const FlashMatch& match, const FlashMatch& others,
                  std::size_t image) {
  std::vector<int> before = match.hypotheses.front().flash;
  before.erase(before.begin() + static_cast<std::ptrdiff_t>(image));
  const std::vector<int>& now = others.hypotheses.front().flash;
  const auto after_first = [&](const std::vector<int>& flash, std::size_t i) {
    return times_s[static_cast<std::size_t>(flash[i])] - times_s[static_cast<std::size_t>(flash[0])];
  };
  for (std::size_t i = 1; i < now.size(); ++i) {
    const double step_s = after_first(now, i) - after_first(now, i - 1);
    if (std::abs(after_first(now, i) - after_first(before, i)) > kSameShare * step_s) return false;
  }
  return true;
}

}  // namespace

std::optional<FalseImage> find_false_image(std::span<const double> times_s, const Track& track,
                                           const std::optional<ArrivalPrior>& prior,
                                           const FlashMatch& match) {
  if (match.explained) return std::nullopt;
  std::optional<FalseImage> found;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < track.images.size(); ++i) {
    if (!can_be_left_out(track, i)) continue;
    const Track others = without(track, i);
    auto other_match = match_flashes(times_s, others, prior);
    if (!other_match || !other_match->steady || !other_match->explained) continue;
    const double d = beyond_expected(others, *other_match);
    if (!(d < least)) continue;
    least = d;
    found = FalseImage{i, std::move(*other_match)};
  }
  if (found && is_as_before(times_s, match, found->match, found->image)) return std::nullopt;
  return found;
}

}  // namespace strobe::host
