// Bounds of how much each effect can change each quantity of the readout, over all possible shots of a scene.
//
// Two kinds of effects.
// - Those of the image (flight, timing, camera) displace what is measured of it. Their headers bound by how
//   much (flight_bounds.hpp, timing_bounds.hpp, camera_bounds.hpp); the reduction's own sensitivities
//   (sensitivity.hpp) carry it to each number. The largest over the corners of the scene's spread
//   (corners.hpp) and, at each, over two phases of the flash train: that with the fewest images, which weigh
//   most, and one more, another at each corner. Times kImageMargin for what lies between the corners and the
//   second order.
// - Those of the contact change the rebound itself (contact_bounds.hpp).
//
// Which images there are is decided by thresholds: the view's edge, flattening that is seen as contact, an
// image that overlaps the surface. A displaced image may pass one. What that can do is measured: with all
// effects the readout at neighbouring ones of kPhases phases of the train (and some more, where
// an image in contact passes for one in the air) differs by what images that come and go do to it (and by a
// smooth part, which only adds). threshold_steps() is the sum of the kThresholds largest such
// steps, the largest over the corners: a shot that passes several thresholds at once changes by no more. It
// counts as soon as anything that displaces images is left out: once, and once more for every image that may
// be carried past a threshold (the displacement over the spacing of images, or in contact by how many the
// images counted differ); and with it, where the sensors' jitter is kept, twice what one image's can do.
// Where pixels are kept, what they do to all images counts twice besides: at another place it is another. A
// number that some phase or corner has not gets an infinite one: nothing that displaces may then be left out.
//
// First order is for small changes. Where the sum is more than kSmall of a number's scale there is no bound
// for it, and none for any where that number is an angle or a velocity in the plane; nor for the dwell time
// where it might come out negative, which is no number.
//
// Deterministic: no clock. Not thread-safe: it keeps what it has measured. Allocates.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "sim/plan/contact_bounds.hpp"
#include "sim/plan/readouts.hpp"
#include "sim/plan/sampled_shots.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

inline constexpr double kImageMargin = 1.5;
inline constexpr double kSmall = 0.25;
inline constexpr int kPhases = 32;
inline constexpr std::size_t kThresholds = 4;

class SceneBounds {
 public:
  explicit SceneBounds(const Scene& scene, const ShootSettings& settings = {});

  /// Whether the scene has the effect at all.
  bool present(Effect effect) const { return present_[static_cast<std::size_t>(effect)]; }

  /// Of leaving out this effect alone, without thresholds.
  PerQuantity of(Effect effect);

  /// Of leaving out all effects that the model lacks, with thresholds: what plans compare with the tolerance.
  PerQuantity of(const Model& model);

  /// Of images that appear or disappear.
  const PerQuantity& threshold_steps() const { return threshold_steps_; }

  /// Why threshold_steps() is infinite, as text; empty unless the reason holds for all quantities.
  const std::string& warning() const { return warning_; }

  /// Shots of the scene, to compare models by.
  SampledShots& samples() { return samples_; }

  const Scene& scene() const { return scene_; }

 private:
  void measure(const ShootSettings& settings);
  void no_bound_where_large(PerQuantity& sum) const;
  void look_for_warnings(const ShootSettings& settings);

  Scene scene_;
  std::array<bool, kEffectCount> present_{};
  std::array<PerQuantity, kEffectCount> images_{};
  std::array<double, kEffectCount> passing_{};  ///< how many images each may carry past a threshold
  ContactBounds contact_;
  SampledShots samples_;
  PerQuantity threshold_steps_;
  double least_dwell_ms_ = std::numeric_limits<double>::infinity();
  PerQuantity one_stamp_;  ///< of one image's time by the sensors' jitter
  std::string warning_;
};

/// Which effects the scene has: their parameters are not those without effect. In the order of Effect.
std::array<bool, kEffectCount> effects_of(const Scene& scene);

}  // namespace strobe::sim
