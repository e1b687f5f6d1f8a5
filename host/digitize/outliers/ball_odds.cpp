#include "host/digitize/outliers/ball_odds.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "host/digitize/path/leg_line.hpp"

namespace strobe::digitize {

namespace {

double normal_density(double off, double sd) {
  return std::exp(-0.5 * off * off / (sd * sd)) / (std::sqrt(2.0 * std::numbers::pi) * sd);
}

}  // namespace

double probability(double log_odds) { return 1.0 / (1.0 + std::exp(-log_odds)); }

double log_prior(std::span<const double> log_odds) {
  constexpr int kSteps = 10;
  double prior = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    double balls = 1.0, none = 1.0;
    for (const double one : log_odds) {
      balls += probability(one + prior);
      none += 1.0 - probability(one + prior);
    }
    prior = std::log(balls / none);
  }
  return prior;
}

double log_odds_of_size(const Outline& outline, const SizeModel& size) {
  // Outlines of anything are of any size that is sought.
  constexpr double kRangeOfDiameter = 0.3;
  const double expected = size.at(outline.centre.x);
  const double sd = std::hypot(std::hypot(outline.diameter_sd(), kSdOfDiameter * expected),
                               std::hypot(size.sd, size.spread));
  const double density = normal_density(outline.diameter - expected, sd);
  return std::log(kUnlikeOthers + (1.0 - kUnlikeOthers) * density * kRangeOfDiameter * expected);
}

double moved_limb_px(const Outline& outline, const SizeModel& size) {
  const double expected = size.at(outline.centre.x), off = outline.diameter - expected;
  const double sd = std::hypot(outline.diameter_sd(), size.sd, size.spread);
  const double moved = kUnlikeOthers * normal_density(off, std::hypot(sd, kSdOfDiameter * expected));
  const double as_it_is = (1.0 - kUnlikeOthers) * normal_density(off, sd);
  if (!(moved > 0.0)) return 0.0;  // farther off than numbers tell, as no ball is
  // What is of any other size is none of the balls.
  const double a_ball = 1.0 - kUnlikeOthers / std::exp(log_odds_of_size(outline, size));
  return std::abs(off) * std::sqrt(a_ball * moved / (moved + as_it_is));
}

void add_moved_limb(Outline& outline) {
  // In any direction alike, so that each coordinate has half of the square.
  const double centre_variance = 0.5 * std::pow(outline.moved_centre_px(), 2);
  outline.covariance(0, 0) += centre_variance;
  outline.covariance(1, 1) += centre_variance;
  outline.covariance(2, 2) += outline.moved_limb_px * outline.moved_limb_px;
}

std::vector<double> log_odds_of(std::span<const Outline> outlines, std::span<const LimbAgreement> limbs,
                                const SizeModel& size) {
  assert(outlines.size() == limbs.size());
  std::vector<double> odds;
  for (std::size_t i = 0; i < outlines.size(); ++i)
    odds.push_back(limbs[i].log_odds + log_odds_of_size(outlines[i], size));
  const double prior = log_prior(odds);
  for (double& one : odds) one += prior;
  return odds;
}

double log_odds_of_path(const Outline& outline, const Photograph& photograph, const PlaneMap& map) {
  // Of what is no ball's one in ten is made of the arcs of two that are, between which the leg passes; any
  // other is near the leg by chance.
  constexpr double kBetweenBalls = 0.1;
  const cv::Point2d middle(0.5 * photograph.width(), 0.5 * photograph.height());
  const double view = std::min(photograph.width(), photograph.height()) / map.image_px_per_plane_px(middle);
  const double near = leg_tolerance({.at = outline.centre, .sd_px = outline.centre_sd()}, outline.diameter);
  return -std::log(kBetweenBalls + 2.0 * near / view);
}

}  // namespace strobe::digitize
