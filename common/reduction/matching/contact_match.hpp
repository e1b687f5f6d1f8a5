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
  std::vector<int> flash;
  double chi_squared = 0.0;
};

/// The most likely flashes of the contact images among those between the legs, by dynamic programming. Model:
/// along the surface a cubic that keeps both velocities, into it a half sine. Allocates in its first matches
/// only.
class ContactMatcher {
 public:
  /// What is given is kept, not copied.
  ContactMatcher(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track)
      : images_(images), times_s_(times_s), track_(track), variance_(place_variance(track)) {}

  /// Valid until the next match.
  const ContactFlashes& match(const LegCandidate& in, const LegCandidate& out);

 private:
  static double place_variance(const Track& track);
  void take_from(int first);
  void set_expected(const geometry::Crossing& down, const geometry::Crossing& off, int first);
  double miss(std::size_t image, std::size_t slot) const;
  double& cost(std::size_t image, std::size_t slot) { return cost_[image * (expected_.size() + 1) + slot]; }
  void fill_costs();

  struct Expected {
    double place_px, depth_px, depth_variance;
  };

  std::span<const TrackPoint> images_;
  std::span<const double> times_s_;
  const Track& track_;
  double variance_;  ///< of an image's place about the model's [px^2]
  ContactFlashes best_;
  std::vector<Expected> expected_;  ///< at each flash between the legs
  std::vector<double> cost_;        ///< the least of the first i images in the first j flashes
};

}  // namespace strobe::matching
