// How plausible the contact between two legs is, and which flashes made its images. No I/O; thread-safe.
#pragma once

#include <span>
#include <vector>

#include "common/reduction/matching/leg_candidates.hpp"

namespace strobe::matching {

/// What two legs with velocities say of the bounce, and its standard deviations.
struct BounceEstimate {
  /// v along and up at touchdown, at lift-off [px/s], dwell [s], distance [px].
  std::array<double, 6> value{};
  std::array<double, 6> sd{};
  /// Of the distance: friction may drive the ball on beyond both velocities.
  double contact_model_sd_px = 0.0;
  DwellLimits dwell{};
};
BounceEstimate estimate_bounce(const LegCandidate& in, const LegCandidate& out, const Track& track);

/// -2 ln likelihood, 0 where all are plausible: of the dwell time, of the mean velocity along the surface (it
/// lies between those before and after, as friction acts one way), and of the restitution.
double contact_penalty(const BounceEstimate& bounce);

struct ContactFlashes {
  std::vector<int> flash;  ///< of each image; kNoFlash of one that is no image of the ball
  /// -2 ln likelihood: of the images' places at these flashes, of flashes between the legs without an image
  /// and of images without a flash. Infinite where the images are certain and more than the flashes.
  double penalty = 0.0;
};

/// The most likely flashes of the contact images among those between the legs, by alignment with gaps on both
/// sides (Needleman and Wunsch, J. Mol. Biol. 48, 1970). Model: along the surface a cubic that keeps both
/// velocities, into it a half sine. Allocates in its first matches only.
class ContactMatcher {
 public:
  /// What is given is kept, not copied.
  ContactMatcher(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track);

  /// A lower bound of the penalty with so many flashes between two legs.
  double least_penalty(int flashes) const;

  /// Valid until the next match.
  const ContactFlashes& match(const LegCandidate& in, const LegCandidate& out);

 private:
  void take_from(int first);
  void set_expected(const geometry::Crossing& down, const geometry::Crossing& off, int first);
  double miss(std::size_t image, std::size_t slot) const;
  double& cost(std::size_t image, std::size_t slot) { return cost_[image * (expected_.size() + 1) + slot]; }
  void fill_costs();
  void trace_back(int first);

  struct Expected {
    double place_px, depth_px, depth_variance;
  };

  std::span<const TrackPoint> images_;
  std::span<const double> times_s_;
  const Track& track_;
  double variance_;                    ///< of an image's place about the model's [px^2]
  double missed_;                      ///< penalty of a flash without an image
  std::vector<double> no_ball_;        ///< of each image, if it is none of the ball's
  std::vector<double> least_no_ball_;  ///< of the first, the first two ... that are likeliest to be none
  ContactFlashes best_;
  std::vector<Expected> expected_;  ///< at each flash between the legs
  std::vector<double> cost_;        ///< the least of the first i images in the first j flashes
};

}  // namespace strobe::matching
