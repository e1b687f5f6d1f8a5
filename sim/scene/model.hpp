// Which effects a simulation computes, and how exactly the contact. The full model has all that the scene
// has; sim/effects leaves out those that change no readout by more than is tolerated. Plain values.
#pragma once

#include <array>
#include <bitset>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

enum class Effect {
  gravity,          ///< in flight
  drag,             ///< in flight
  magnus,           ///< in flight
  spin_decay,       ///< in flight
  contact_gravity,  ///< the weight during contact, along an inclined plate and towards it
  grip,             ///< the contact point may come to a stop; without it friction is at its limit throughout
  offset,           ///< the normal force stands ahead of the centre
  tangential_compliance,  ///< grip and slip of the tangential spring; without it one number, e_x
  contact_ode,            ///< motion in contact by the ODE; without it by a damped sine
  flash_duration,         ///< an image is the mean over the flash
  lamp_delay,             ///< pulse to flash
  lamp_jitter,            ///< from flash to flash
  sensor_delay,           ///< flash to edge, and its jitter
  shutter_lag,            ///< line to shutter, and its jitter
  perspective,            ///< size by distance from the focused plane; oblique view off the axis
  lens_distortion,
  pixels,  ///< images are rendered on pixels and measured there
};

inline constexpr std::array<std::string_view, 17> kEffectNames{
    "gravity",         "drag",           "magnus",      "spin_decay",
    "contact_gravity", "grip",           "offset",      "tangential_compliance",
    "contact_ode",     "flash_duration", "lamp_delay",  "lamp_jitter",
    "sensor_delay",    "shutter_lag",    "perspective", "lens_distortion",
    "pixels"};
inline constexpr std::size_t kEffectCount = kEffectNames.size();

constexpr std::string_view name(Effect effect) { return kEffectNames[static_cast<std::size_t>(effect)]; }

constexpr std::optional<Effect> effect_from_name(std::string_view text) {
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    if (kEffectNames[i] == text) return static_cast<Effect>(i);
  }
  return std::nullopt;
}

/// Tolerance to which the full model solves the contact's mechanics.
inline constexpr double kFullContactTolerance = 1e-9;

class Model {
 public:
  static Model full() { return Model(std::bitset<kEffectCount>().set()); }
  static Model none() { return Model({}); }

  bool has(Effect effect) const { return effects_[static_cast<std::size_t>(effect)]; }
  Model with(Effect effect, bool on = true) const {
    Model other = *this;
    other.effects_[static_cast<std::size_t>(effect)] = on;
    return other;
  }
  Model without(Effect effect) const { return with(effect, false); }

  /// How exactly the contact's mechanics are solved: 1e-12…1e-3, as impact::ContactOptions has it.
  double contact_tolerance() const { return contact_tolerance_; }
  Model with_contact_tolerance(double tolerance) const {
    Model other = *this;
    other.contact_tolerance_ = tolerance;
    return other;
  }
  bool operator==(const Model&) const = default;

 private:
  explicit Model(std::bitset<kEffectCount> effects) : effects_(effects) {}
  std::bitset<kEffectCount> effects_;
  double contact_tolerance_ = kFullContactTolerance;
};

// Models as text, for the command line. Pure; thread-safe; allocates.

/// "full", "none", a list of the effects to have ("gravity,grip"), or of those to leave out of the full model
/// ("-pixels,-drag"; "full-pixels-drag" is the same). The error names the word.
Result<Model> parse_model(std::string_view text);

/// "full", "none", or the list of effects, whichever is the shortest of the forms above.
std::string model_text(const Model& model);

// A scene with the effects removed that a model leaves out: their keys take the values at which they have no
// effect. The other numbers drawn for a shot stay the same, since a spread of zero takes its draw as well.
// Effects that no key can turn off (gravity, and those of the contact) are left out by BallPath. Pure;
// thread-safe; copies the scene.

Scene reduced_scene(const Scene& scene, const Model& model);

}  // namespace strobe::sim
