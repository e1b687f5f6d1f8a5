#include "host/digitize/outliers/ghosts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "host/digitize/core/statistics.hpp"
#include "host/digitize/outliers/ball_odds.hpp"

namespace strobe::digitize {
namespace {

// Logarithms of the light of one disc over that of another. Flashes of one train differ by at most 30 % in
// energy, and their lamps' light falls off with the way from ball to ball.
constexpr double kFlashVariance = 0.04, kVariancePerDiameter = 0.05;
// Where another thing, as light as the ball, hides more or less of the limb, any share from a twentieth
// (e^-3) on is as likely: of 1506 images on altered renders 2 % show less than half of the next one's.
constexpr double kRangeOfHidden = 3.0;
// Where the level of ambient light is not known: from a twentieth to a quarter of a flash's.
constexpr double kGhostMean = -2.0, kGhostSd = 0.6;
// Where it is measured, about that; but on one in ten of 178 renders with a trail less than a third of it
// was, as it passes what is bright.
constexpr double kAboutLevel = 0.3, kWrongLevel = 0.1;
// What looks most like a ball may be a ghost that is bright: with more, drawn ghosts of a third of a flash's
// light pass. What looks little like one is dim, whether ball or ghost: its share has
// that already.
constexpr double kMaxOdds = 2.0;

/// Of a normal distribution, as dense below its mean as at it.
double density(double value, double mean, double sd) {
  const double beyond = std::max(0.0, value - mean) / sd;
  return std::exp(-0.5 * beyond * beyond) / (std::sqrt(2.0 * std::numbers::pi) * sd);
}

double log_of(double share) { return std::log(std::max(share, 1e-3)); }

/// What is known of the picture's ambient light.
struct Level {
  std::optional<double> measured;         ///< share of a flash's
  double at_least_log = -kRangeOfHidden;  ///< as other ghosts show it

  /// A shutter that opens or shuts meanwhile, or a lamp that flickers, makes ghosts of any less light.
  double density_of_ghost(double log_share) const {
    const double known =
        density(at_least_log, kGhostMean, kGhostSd) / density(kGhostMean, kGhostMean, kGhostSd);
    const double anywhere = density(std::max(log_share, at_least_log), kGhostMean, kGhostSd) / known;
    if (!measured) return anywhere;
    const double level = std::max(log_of(*measured), -kRangeOfHidden);
    return kWrongLevel * anywhere + (1.0 - kWrongLevel) * density(log_share, level, kAboutLevel);
  }
};

/// log(p / (1 - p)) that a disc of that share of a ball's light is a ball's.
double log_odds_of_share(double share, double apart_of_diameter, const Level& level) {
  const double sd = std::sqrt(kFlashVariance + kVariancePerDiameter * apart_of_diameter);
  const double log_share = std::min(0.0, log_of(share));
  const double ball = kUnlikeOthers / kRangeOfHidden + (1.0 - kUnlikeOthers) * density(-log_share, 0.0, sd);
  return std::log(ball / level.density_of_ghost(log_share));
}

/// Median over the directions, as lamps stand still and light both alike: what crosses a limb disturbs a few
/// of them only.
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

std::vector<Lit> compared_by(std::span<const LitDisc> discs, const Level& level) {
  std::vector<double> rise;
  for (const LitDisc& disc : discs) rise.push_back(typical_rise(disc.limb));
  std::vector<std::size_t> brightest_first(discs.size());
  std::iota(brightest_first.begin(), brightest_first.end(), std::size_t{0});
  std::ranges::stable_sort(brightest_first, std::ranges::greater{}, [&](std::size_t i) { return rise[i]; });
  std::vector<std::size_t> balls;
  std::vector<Lit> lit(discs.size());
  for (const std::size_t i : brightest_first) {
    const LitDisc& disc = discs[i];
    std::optional<std::size_t> nearest;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t ball : balls) {
      const double apart = cv::norm(discs[ball].centre - disc.centre);
      if (apart < least) least = apart, nearest = ball;
    }
    if (nearest) {
      const double share = share_of(disc.limb, discs[*nearest].limb);
      lit[i] = {share, log_odds_of_share(share, least / disc.diameter, level) +
                           std::clamp(disc.log_odds, 0.0, kMaxOdds)};
    }
    if (!lit[i].ghost() && disc.log_odds >= kCertainOdds) balls.push_back(i);
  }
  return lit;
}

}  // namespace

std::vector<Lit> compare_light(std::span<const LitDisc> discs, std::optional<double> ambient_share) {
  Level level{.measured = ambient_share};
  for (const Lit& disc : compared_by(discs, level))
    if (disc.ghost()) level.at_least_log = std::max(level.at_least_log, std::min(0.0, log_of(disc.share)));
  return compared_by(discs, level);
}

double probability_beside_ghosts(double probability, const Lit& lit) {
  return probability / (1.0 + probability * std::exp(-lit.log_odds));
}

}  // namespace strobe::digitize
