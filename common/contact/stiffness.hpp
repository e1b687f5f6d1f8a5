// The contact's stiffness: several definitions of it, which differ since a damped pulse is not a linear
// spring. Pure; thread-safe.
#pragma once

#include "common/contact/spin_pulse.hpp"

namespace strobe::contact {

/// In N/m where nothing else is said.
struct Stiffness {
  double half_period = 0.0;  ///< m(pi/dwell)²: the contact is half a period of an undamped spring
  double secant = 0.0;       ///< largest force over largest deformation of the pulse
  double energy = 0.0;       ///< m·vy²/depth²: all of the energy is stored at the deepest point
  /// Spring of the damped oscillator with this e and dwell time, released where N = 0
  /// (impact/ode/normal_spring.hpp); 0 for e < 0.001.
  double kelvin_voigt = 0.0;
  double kelvin_voigt_zeta = 0.0;     ///< its damping ratio
  double kelvin_voigt_damping = 0.0;  ///< its c, N·s/m
  double compression = 0.0;           ///< m(pi/(2·t_depth))²: a quarter period to the deepest point
  double peak_time = 0.0;             ///< m(pi/(2·t_peak))²: a quarter period to the largest force
};

/// Errors as SpinPulse::make().
tl::expected<Stiffness, impact::InputError> stiffness(const SpinPulseInput& input);

}  // namespace strobe::contact
