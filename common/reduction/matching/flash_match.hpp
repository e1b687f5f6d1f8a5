// Which flash made which image of the ball: the plausible assignments by order, spacing, ballistic flight and
// a plausible contact, and how probable each is.
//
// Data association with many hypotheses: a hypothesis assigns a flash to every image. Its weight is its
// posterior probability, proportional to exp(-d/2) with
//   d = chi squared of both legs' flight (the images' noise, the errors in time and of the air's pull, and
//   each leg's
//       position and velocity free)
//     + -2 ln of the share of images that are not found, for every flash within the path without an image,
//       and of the probability that an image in contact is none of the ball's, for every one without a flash
//     + the penalties of contact_match.hpp for a bounce that balls do not make, and for images in contact
//     + 2 ln(1 + z^2) of the arrival, where there is a prior for it.
// Where the noise as stated explains not even the likeliest hypothesis, chi squared is divided by what it
// then is over its degrees of freedom.
// Source: Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 1.4.16
// (mixtures); Blackman, Multiple hypothesis tracking for multiple target tracking (2004). Deterministic, no
// I/O; thread-safe; allocates. 166 flashes and a dozen images take a fraction of a millisecond.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "common/reduction/matching/track.hpp"

namespace strobe::matching {

/// When the ball is expected at the surface, from the gate or the machine's lag. A weak prior.
struct ArrivalPrior {
  double touchdown_s = 0.0;  ///< on the time axis of the flashes
  /// Half-width of a Cauchy density, whose long tails allow for a machine far off its usual lag.
  double scale_s = 0.010;
};

/// A hypothesis: for each image the number of its flash among the observed ones, ascending; kNoFlash of an
/// image between two legs that is none of the ball's.
struct FlashAssignment {
  std::vector<int> flash;
  double weight = 1.0;
};

struct FlashMatch {
  /// The likeliest first, with most of the probability; their weights add up to 1. Never empty.
  std::vector<FlashAssignment> hypotheses{FlashAssignment{}};
  /// For each observed flash, 1 if it lies within one of the plausible assignments.
  std::vector<char> possibly_imaged;
  double chi_squared = 0.0;  ///< flight of both legs, of the likeliest
  double penalty =
      0.0;  ///< of the likeliest, the rest of d above: bounce, images in contact, missed ones, arrival
  /// Probability that the images are of other flashes than the likeliest has, 0 to 1. The intervals of an
  /// even train leave open which flashes they are, however certain the numbers; those of a coded train tell.
  double misassignment_probability = 0.0;
  bool explained = true;  ///< the noise as stated explains the flight of the likeliest
  bool steady = true;     ///< false: no steady speed fits; the images are assigned to consecutive flashes
};

/// Whether all hypotheses have as many flashes between one image and the next.
bool gaps_agree(const FlashMatch& match);

/// Probability of the hypotheses that are dropped: together they are rarer than an outlier that no test
/// finds.
inline constexpr double kDroppedProbability = 0.01;
/// Above this the code of a coded train leaves open which flashes made the images.
inline constexpr double kMaxMisassignmentProbability = 0.01;

/// times_s: observed flashes, ascending, any origin. Returns nullopt if there are fewer flashes than images.
std::optional<FlashMatch> match_flashes(std::span<const double> times_s, const Track& track,
                                        const std::optional<ArrivalPrior>& prior);

/// Of the residuals from steady flight: each leg's images have two coordinates, its position and velocity
/// take up four.
double degrees_of_freedom(const Track& track);

/// How far the images are from steady flight at the times of their flashes, rms of a coordinate [px]; 0 where
/// too few images leave that open, infinite where no steady flight leads to flashes at all.
double off_steady_px(const Track& track, const FlashMatch& match);

/// False where the images are further off than a lens that no calibration undoes bends a flight: the
/// assignment to legs or flashes is then wrong, and so is every number.
bool is_steady(const Track& track, const FlashMatch& match);

/// An image that no flash made, among those of a flight.
struct FalseImage {
  std::size_t image = 0;  ///< of the track
  FlashMatch match;       ///< of the other images, in the track's order
};

/// The image without which the noise as stated explains the flight, where it does not with it, and without
/// which the others have other times. An image that is only misplaced leaves the others' times as they are:
/// it is the reduction's to leave out. Returns nullopt where there is none; three images of a leg in the air
/// are kept.
/// Source: leave-one-out consistency, as of receiver autonomous integrity monitoring (Brown, 1992).
std::optional<FalseImage> find_false_image(std::span<const double> times_s, const Track& track,
                                           const std::optional<ArrivalPrior>& prior, const FlashMatch& match);

}  // namespace strobe::matching
