// Images that do not fit their leg. Part of the reduction, not of its interface. Thread-safe.
#pragma once

#include <functional>

#include "common/reduction/shot_fit.hpp"

namespace strobe::reduction {

/// Of three measurements of a kind that disagree none can be singled out.
inline constexpr int kMinForOutlier = 4;

/// Degrees of freedom of the sds that a digitizer states of each image: of 18,647 airborne images on 1000
/// rendered photographs 4 in 10,000 centres and equators lie beyond 4.5 sds of their leg's others, as of t
/// with as many (of a normal number 7 in a million).
inline constexpr double kDigitizersFreedom = 15.0;

/// How far what was left out contradicts the rest: beyond chance if the sds were known exactly, or as well as
/// they are, too.
enum class Contradiction { none, doubtful, clear };

/// Marks measurements as not to be used that are further from what the others predict than chance explains:
/// one clean photograph in a thousand loses a measurement, however many images it has (Bonferroni). The test
/// is leave-one-out: chi squared where the noise is stated, F or t where it was estimated. The worst goes
/// first, and `fit_again` is called before the rest is judged. Needs kMinForOutlier measurements of a kind.
/// Where images come with probabilities of being a ball's, the less probable of the centres take more of
/// those false alarms and the others less, and one that is left out says the less against the noise.
///
/// Where more than a quarter of a kind would have to go, or the rest still scatters as one in a hundred would
/// with the stated noise, the noise may be wrong and not the images: all are taken back and judged by their
/// own scatter (F), so that only what stands out of that is left out.
Contradiction reject_outliers(ShotFit& fit, const std::function<void()>& fit_again);

}  // namespace strobe::reduction
