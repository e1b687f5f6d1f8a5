// The integrals of the damped sine pulse exp(-f·theta)·sin(theta) over 0…theta: the velocity and the position
// of a ball in contact. Their textbook forms lose digits by cancellation of order theta² and theta³ at the
// start of the contact; here they are sums of terms of one sign, accurate to 1e-13 relative over the whole
// range (tests compare with 50 digits). Pure functions, no allocation: thread-safe, real-time safe.
#pragma once

#include <tl/expected.hpp>

#include "common/impact/input_error.hpp"

namespace strobe::impact {

/// An angle of the pulse with its functions, which a caller may know more accurately than theta alone gives
/// (near lift-off, where pi - theta is small).
struct PulsePhase {
  double theta_rad = 0.0;
  double decay = 1.0;  ///< exp(-f·theta)
  double sine = 0.0;
  double cosine = 1.0;
  double half_sine = 0.0;  ///< sin(theta/2)

  static PulsePhase at_angle(double damping_f, double theta_rad);
  /// theta = pi·time_fraction; the sine keeps its relative accuracy up to fraction 1, where it is 0.
  static PulsePhase at_fraction(double damping_f, double time_fraction);
};

/// I1 = integral of exp(-f·phi)·sin(phi): impulse over m·|vy_TD|.
///    = [1 - exp(-f·theta)(f·sin + cos)]/(1 + f²)
double impulse_integral(double damping_f, const PulsePhase& phase);

/// I2 = integral of I1: displacement lost to friction, over its ratio and |vy_TD|·dwell/pi.
///    = theta/(1 + f²) - {exp(-f·theta)[(1 - f²)·sin - 2f·cos] + 2f}/(1 + f²)²
double displacement_integral(double damping_f, const PulsePhase& phase);

/// theta - I2: depth of the centre over |vy_TD|·dwell/pi.
double depth_integral(double damping_f, const PulsePhase& phase);

/// The simplified pulse's counterparts: 1 - exp(-f·theta)·cos(theta) and theta - exp(-f·theta)·sin(theta).
double simplified_impulse(double damping_f, const PulsePhase& phase);
double simplified_displacement(double damping_f, const PulsePhase& phase);

inline constexpr double kLargestDamping = 10.0;

struct PulseIntegrals {
  double impulse = 0.0;       ///< I1
  double displacement = 0.0;  ///< I2
  double depth = 0.0;         ///< theta - I2
};

/// All three. Valid: 0 <= f <= 10, 0 <= theta <= pi; otherwise not_finite or phase_out_of_range.
tl::expected<PulseIntegrals, InputError> pulse_integrals(double damping_f, double theta_rad);

}  // namespace strobe::impact
