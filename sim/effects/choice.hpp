// Which effects a simulation of a scene has to compute, so that the numbers read from its shots stay within a
// tolerance of what they would be with all of them.
//
// What is decided: what costs something, measured by `strobe-sim effects`. Pixels make a shot some twenty
// times as expensive; how exactly the contact is solved, its motion by the ODE and the mean over the flash
// are half of what is left. All other effects cost next to nothing: leaving them out would only add to the
// error.
//
// How. Up to kCandidates models, the cheapest first, are simulated beside the full one, kSampledShots shots
// each, digitized without error, by a seed of their own: the first one that changes no number by more than
// kSampledPart of its tolerance is taken, the full one if none. What is said holds with kConfidence: if a
// share p of a scene's shots changed some number by more than that, all sampled ones would pass with a
// probability of at most (1 - p)^kSampledShots; that any of kCandidates such models passes, with at most
// kCandidates times that. Hence p is below sampled_share():
//   p = 1 - ((1 - kConfidence)/kCandidates)^(1/kSampledShots).
// The order is fixed, since a choice must not depend on how busy a machine is.
//
// Deterministic. A chooser is not thread-safe: it keeps the full model's readouts. Allocates.
#pragma once

#include <array>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "sim/effects/tolerances.hpp"
#include "sim/scene/model.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

/// The effects that cost something, the most expensive first.
inline constexpr std::array kDecided{Effect::pixels, Effect::contact_ode, Effect::flash_duration};
bool is_decided(Effect effect);

inline constexpr int kSampledShots = 500;
inline constexpr int kCandidates = 6;
inline constexpr double kSampledPart = 0.5;
inline constexpr double kConfidence = 0.95;

/// 0.95 %.
double sampled_share();

/// The model with all effects that the scene has: their parameters are not those without effect.
Model effects_of(const Scene& scene);

struct ModelChoice {
  Model model = Model::full();  ///< without effects that the scene has not
  double tolerance = 0.0;       ///< relative, as asked for
  PerQuantity tolerances;       ///< in the quantities' units
  PerQuantity allowed;          ///< change of a sampled shot
  /// The largest change of a sampled shot; absent where no candidate passed, so that nothing is left out.
  std::optional<PerQuantity> changed;
};

class ModelChooser {
 public:
  /// Settings that Shooter::make() accepts, else nothing is ever left out.
  explicit ModelChooser(const Scene& scene, const ShootSettings& settings = {});

  /// `tolerance`: relative, above 0, at most 1; the scene's own [readout] overrides it (tolerances.hpp).
  ModelChoice choose(double tolerance);

  /// All effects that the scene has.
  const Model& present() const { return present_; }

  /// The largest change of each number that one effect makes in the sampled shots. For other effects than the
  /// pixels both models lack these, which would hide what is smaller than they are.
  PerQuantity change_by(Effect effect);

 private:
  /// The sampled shots of one model, simulated as they are asked for.
  struct Sample {
    Model model;
    std::optional<Shooter> shooter;
    std::vector<reduction::Quantities> readouts{};
  };
  Sample& sample_of(const Model& model);
  /// Returns nullopt once a change is more than `allowed`.
  std::optional<PerQuantity> largest_change(const Model& model, const Model& other,
                                            const PerQuantity& allowed);

  Scene scene_;
  ShootSettings settings_;
  Model present_;
  std::deque<Sample> samples_;
};

/// One line of text: the effects left out, and what the sampled shots say of it.
std::string explanation(const ModelChoice& choice, const Scene& scene);

}  // namespace strobe::sim
