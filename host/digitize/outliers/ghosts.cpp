#include "host/digitize/outliers/ghosts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "host/digitize/core/statistics.hpp"

namespace strobe::digitize {
namespace {

// Flashes of one train differ by at most 30 % in energy (limb_agreement.cpp). Less than half a diameter apart two
// flashes light a ball alike; further on the lamps' light may fall off by as much again, and noise and blur take a
// fifth of the rise of an outline that another half hides: .7² · .8 = .4.
constexpr double kMinShareBeside = 0.7;
constexpr double kMinShare = 0.4;
constexpr double kBesideOfDiameter = 0.5;
// Beyond, light may have fallen off by any amount.
constexpr double kReachOfDiameter = 2.0;

/// Median over the directions, as lamps stand still and light both alike: what crosses a limb disturbs a few of
/// them only.
double typical_rise(const Limb& limb) {
  std::vector<double> rises(limb.begin(), limb.end());
  std::erase_if(rises, [](double rise) { return std::isnan(rise); });
  return median(std::move(rises));
}

/// Of the rise across the ball's limb, the disc's. Returns 1 if they have no direction in common.
double share_of(const Limb& disc, const Limb& ball) {
  std::vector<double> shares;
  for (std::size_t k = 0; k < disc.size(); ++k)
    if (!std::isnan(disc[k]) && ball[k] > 0.0F) shares.push_back(disc[k] / ball[k]);
  return shares.empty() ? 1.0 : median(std::move(shares));
}

}  // namespace

std::vector<Ghost> find_ghosts(std::span<const LitDisc> discs) {
  std::vector<double> rise;
  for (const LitDisc& disc : discs) rise.push_back(typical_rise(disc.limb));
  std::vector<std::size_t> brightest_first(discs.size());
  std::iota(brightest_first.begin(), brightest_first.end(), std::size_t{0});
  std::ranges::stable_sort(brightest_first, std::ranges::greater{}, [&](std::size_t i) { return rise[i]; });
  std::vector<std::size_t> balls;
  std::vector<Ghost> ghosts;
  for (const std::size_t i : brightest_first) {
    const LitDisc& disc = discs[i];
    std::optional<std::size_t> nearest;
    double least = kReachOfDiameter * disc.diameter;
    for (const std::size_t ball : balls) {
      const double apart = cv::norm(discs[ball].centre - disc.centre);
      if (apart < least) least = apart, nearest = ball;
    }
    const double share = nearest ? share_of(disc.limb, discs[*nearest].limb) : 1.0;
    const bool beside = least < kBesideOfDiameter * disc.diameter;
    if (share < (beside ? kMinShareBeside : kMinShare))
      ghosts.push_back({static_cast<int>(i), share});
    else if (disc.certain)
      balls.push_back(i);
  }
  return ghosts;
}

}  // namespace strobe::digitize
