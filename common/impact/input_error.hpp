// Errors of the impact models: what is wrong with their inputs. An enumeration, so that the models allocate
// nothing.
#pragma once

#include <array>
#include <string_view>

namespace strobe::impact {

enum class InputError {
  not_finite,                ///< NaN or infinity among the inputs
  not_approaching,           ///< vy at touchdown is not negative: the ball does not move towards the surface
  restitution_out_of_range,  ///< e outside 0…1
  friction_negative,         ///< mu below 0
  tangential_restitution_out_of_range,  ///< e_x outside -1…1 (outside of it a grip would feed energy)
  offset_out_of_range,     ///< offset below 0, not below the radius, or its reference speed not positive
  ball_out_of_range,       ///< diameter, mass or alpha outside ball::check
  dwell_not_positive,      ///< dwell time of 0 or less
  damping_undefined,       ///< e = 0 in the simplified pulse, whose damping would be infinite
  phase_out_of_range,      ///< damping outside 0…10 or an angle of the pulse outside 0…pi
  magnitude_out_of_range,  ///< a finite number, but too large or too small for the model's arithmetic
  spring_out_of_range,     ///< a contact spring's or dashpot's ratio outside the range its model states
  tolerance_out_of_range,  ///< an integrator's tolerance or number of steps outside its range
  no_release,              ///< the ball does not leave the surface: its weight holds it there
  too_many_steps,          ///< more steps or events than an integration allows
};

/// Largest and smallest magnitude of the closed forms' inputs, within which none of their products or
/// quotients overflows; beyond it magnitude_out_of_range. The smallest applies to divisors (vy, diameter,
/// mass, alpha, dwell time, reference speed); all other inputs may be smaller, or 0.
inline constexpr double kMaxMagnitude = 1e30;
inline constexpr double kMinMagnitude = 1e-30;

/// Both are true of NaN.
constexpr bool too_large(double value) { return !(value <= kMaxMagnitude && value >= -kMaxMagnitude); }
constexpr bool too_small(double value) { return !(value >= kMinMagnitude); }

constexpr std::string_view message(InputError error) {
  constexpr std::array<std::string_view, 15> words{
      "inputs must be finite numbers",
      "vy must be negative: the ball must move towards the surface",
      "e must be from 0 to 1",
      "mu must not be negative",
      "ex must be from -1 to 1",
      "offset must be at least 0 and less than the radius",
      "diameter and mass must be positive, alpha in (0, 2/3]",
      "dwell time must be positive",
      "the simplified pulse needs e above 0",
      "damping must be from 0 to 10, the pulse's angle from 0 to pi",
      "a speed, a length, a mass or a time is too large or too small to compute with",
      "e is below 0.001, or a spring or damping ratio is out of its range",
      "tolerance or number of steps is out of its range",
      "the ball does not leave the surface: its weight holds it there",
      "the contact takes more steps or events than the integration allows",
  };
  return words[static_cast<std::size_t>(error)];
}

}  // namespace strobe::impact
