// That an outline is one of the ball's images: what limb, size, the other outlines of the picture and the
// path say adds up, as logarithms of odds, log(p / (1 - p)). Learnt on rendered photographs; of those that
// were told with a probability p as many were balls. Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outliers/limb_agreement.hpp"
#include "host/digitize/outliers/selection.hpp"

namespace strobe::digitize {

/// One ball in twenty does not look like the others, as something lies under its limb or hides it: it may be
/// of any size, or of any light.
inline constexpr double kUnlikeOthers = 0.05;

double probability(double log_odds);

/// How many of a picture's outlines are balls' differs from picture to picture: log odds of any of them, from
/// what each one's own say (expectation maximization from one ball and one other thing beside them).
double log_prior(std::span<const double> log_odds);

/// What it adds that its diameter is the ball's or not, as far as both are known.
double log_odds_of_size(const Outline& outline, const SizeModel& size);

/// What lies under one side of an outline moves it there, so that its size is not the others' and its centre
/// is off as well: Outline::moved_limb_px.
double moved_limb_px(const Outline& outline, const SizeModel& size);

/// Adds the outline's moved_limb_px to its covariance.
void add_moved_limb(Outline& outline);

/// By limb and size, with the prior; one for each outline, in their order.
std::vector<double> log_odds_of(std::span<const Outline> outlines, std::span<const LimbAgreement> limbs,
                                const SizeModel& size);

/// What it adds that an outline lies on a leg.
double log_odds_of_path(const Outline& outline, const Photograph& photograph, const PlaneMap& map);

}  // namespace strobe::digitize
