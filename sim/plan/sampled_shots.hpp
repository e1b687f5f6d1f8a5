// Whether a model's shots differ from the full model's by more than is allowed, by simulating both. What is said holds with
// kConfidence: if a share p of a scene's shots changed some number by more than is allowed, all of kSampledShots drawn
// ones would pass with a probability of at most (1 - p)^kSampledShots; of kCandidates models that a plan may ask about
// one after another, some such one passes with at most kCandidates times that. Hence p is below sampled_share():
//   p = 1 - ((1 - kConfidence)/kCandidates)^(1/kSampledShots).
// The shots are a seed's of their own, digitized without error. Deterministic. Not thread-safe: it keeps the full model's
// readouts. Allocates.
#pragma once

#include <optional>
#include <vector>

#include "sim/plan/readouts.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

inline constexpr int kSampledShots = 500;
inline constexpr int kCandidates = 6;
inline constexpr double kConfidence = 0.95;

/// 0.95 %.
double sampled_share();

class SampledShots {
 public:
  SampledShots(const Scene& scene, const ShootSettings& settings);

  /// The largest change of each number over all sampled shots against the full model. Returns nullopt if any change
  /// is more than `allowed`, or if a number is there in one model only.
  std::optional<PerQuantity> largest_change(const Model& model, const PerQuantity& allowed);

 private:
  const reduction::Quantities& full_readout(int shot);

  Scene scene_;
  ShootSettings settings_;
  std::optional<Shooter> full_;
  std::vector<reduction::Quantities> readouts_;
};

}  // namespace strobe::sim
