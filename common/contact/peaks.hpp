// Largest force, deformation and friction of the damped sine pulse and when they occur (the thesis's Table
// 16), and the measured drop of the ball's top beside the pulse's depth; with standard deviations by the
// delta method. Pure; thread-safe; what returns a Result allocates.
#pragma once

#include <optional>

#include "common/contact/spin_pulse.hpp"
#include "common/data/contact_set.hpp"
#include "common/units/value_sd.hpp"

namespace strobe::contact {

struct Peak {
  ValueSd size;
  ValueSd time_s;
  ValueSd fraction;  ///< time over the dwell time
};

struct Peaks {
  Peak normal_force;    ///< N
  Peak deformation;     ///< m, displacement of the centre towards the surface
  Peak friction_force;  ///< N, magnitude, up to the grip. The thesis has mu·(largest normal force).
  ValueSd total_rotation_rad;
  std::optional<ValueSd> grip_fraction;  ///< skid-to-grip; absent if the ball slides throughout
  std::optional<ValueSd> grip_time_s;
};

/// Standard deviations of the pulse's inputs, taken as independent of each other; each >= 0.
struct SpinPulseSd {
  double vx_mps = 0.0, vy_mps = 0.0, omega_radps = 0.0;
  double e = 0.0, mu = 0.0, dwell_s = 0.0;
  double diameter_m = 0.0, mass_kg = 0.0, alpha = 0.0, offset_m = 0.0;
};

/// Derivatives by differences over a hundredth of each sd, central, or one-sided where an input would leave
/// its range (e above 1). A grip fraction's sd holds while the grip stays within the contact; near its end
/// the distribution is skewed. Errors: those of SpinPulse::make(); not_finite for an sd that is negative or
/// not finite.
tl::expected<Peaks, impact::InputError> peaks(const SpinPulseInput& input, const SpinPulseSd& sd);

/// Displacement of the top of the ball over that of the pulse's centre: the factor that fits the images
/// between the end points best, sum(y·Y)/sum(Y²).
struct DropRatio {
  double ratio = 0.0;
  std::optional<double> sd_images;  ///< from the residuals of the images; absent where these are rounding
  double sd_inputs = 0.0;           ///< from the sds given, of the pulse and of the diameter
  double see_m = 0.0;               ///< about the scaled pulse, N - 1 degrees of freedom
  double depth_m = 0.0;             ///< ratio · the pulse's depth: the measured deformation of the top
  int n = 0;
};

/// Fails like peaks(), and on fewer than two images between the end points.
Result<DropRatio> drop_ratio(const data::ContactSet& set, const SpinPulseInput& input, const SpinPulseSd& sd);

}  // namespace strobe::contact
