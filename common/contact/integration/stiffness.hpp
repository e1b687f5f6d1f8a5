// The contact's stiffness: several definitions of it, which differ since a damped pulse is not a linear
// spring, and hypotheses about how stiffnesses published elsewhere were computed. Pure; thread-safe;
// explain_stiffness() and fixed_depth_m() allocate.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "common/contact/integration/spin_pulse.hpp"

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

/// A stiffness published for a condition.
struct PublishedStiffness {
  SpinPulseInput input;  ///< the condition's means
  double vy_lo_mps = 0.0;
  double stiffness = 0.0;        ///< N/m, > 0
  double measured_drop_m = 0.0;  ///< largest drop of the top among the images, > 0
};

/// One hypothesis about how the published stiffnesses were computed. It explains them if the ratios are 1
/// within rounding; it is proportional to them if the ratios are equal to each other.
struct StiffnessHypothesis {
  std::string_view name;
  std::vector<double> predicted;  ///< N/m, for each condition
  std::vector<double> ratio;      ///< published over predicted
  double common_ratio = 0.0;      ///< their geometric mean
  double spread = 0.0;            ///< sd of their logarithms
};

/// All definitions of Stiffness; Hertz's and stiffer contacts (F ~ depth^n, n = 1.5, 2.6) of the same dwell
/// time; the pulse's largest force over the measured drop; and the largest force of an undamped half wave of
/// the measured impulse, pi·m·(vy_LO - vy_TD)/(2·dwell), over one depth for all conditions (fixed_depth_m()).
/// Errors: those of stiffness(); not_finite for fewer than two conditions or a value out of range.
tl::expected<std::vector<StiffnessHypothesis>, impact::InputError> explain_stiffness(
    std::span<const PublishedStiffness> published);

/// The depth that turns the half wave's largest force into the published stiffness, for each condition.
std::vector<double> fixed_depth_m(std::span<const PublishedStiffness> published);

}  // namespace strobe::contact
