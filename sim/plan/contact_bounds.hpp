// How far leaving out effects of the contact (contact_gravity, grip, offset, tangential_compliance,
// contact_ode) can change each readout. They change the rebound itself, and the mechanics have no closed form
// whose change could be bounded term by term; but what they do is smooth and mostly monotonic in the few
// numbers that are drawn for a shot, apart from where sliding turns into gripping. Hence both simulations are
// made at the corners of the scene's spread, where monotonic changes are largest, and at kInside points
// spread evenly inside, where a change of regime may lie; each is photographed at kContactPhases phases of
// the flash train, one of them with a flash in contact that still passes for one in the air, and read. The
// bound is the largest difference times kContactMargin.
//
// The margin, why 2: between two neighbours of kInside points a change with one kink (where gripping begins)
// is at most twice as large as at the nearer one. Tests hold it against direct simulations.
//
// The effects depend on each other (without a grip the tangential spring does nothing): a set of them is
// measured as a set. Deterministic. Not thread-safe (it keeps what it has measured). Allocates.
#pragma once

#include <array>
#include <map>
#include <vector>

#include "sim/plan/nominal_shot.hpp"
#include "sim/plan/readouts.hpp"

namespace strobe::sim {

inline constexpr std::array<Effect, 5> kContactEffects{Effect::contact_gravity, Effect::grip, Effect::offset,
                                                       Effect::tangential_compliance, Effect::contact_ode};
inline constexpr int kInside = 32;
inline constexpr int kContactPhases = 2;
inline constexpr double kContactMargin = 2.0;

constexpr bool of_contact(Effect effect) {
  for (const Effect e : kContactEffects) {
    if (e == effect) return true;
  }
  return false;
}

class ContactBounds {
 public:
  ContactBounds(const Scene& scene, const ShootSettings& settings);

  /// Of leaving out the effects above that the model lacks.
  const PerQuantity& of(const Model& model) { return known(model).bound; }

  /// Largest difference in the number of images.
  double images_passing(const Model& model) { return known(model).images_passing; }

 private:
  struct Sample {
    Corner corner;
    bool ball = false;  ///< the contact's mechanics let it bounce
    std::array<std::vector<NominalFlash>, kContactPhases> flashes;
    std::array<reduction::Quantities, kContactPhases> readouts;  ///< with all effects
    std::array<std::size_t, kContactPhases> rebounds{};          ///< images of the rebound
  };
  struct Measured {
    PerQuantity bound;
    double images_passing = 0.0;
  };
  const Measured& known(const Model& model);
  Measured measure(const Model& model) const;

  Scene scene_;
  std::vector<Sample> samples_;
  std::map<unsigned, Measured> known_;  ///< by the bits of what is left out
};

}  // namespace strobe::sim
