// Predictions of the fitted contact ODE for each measured condition: when the ball stops skidding, and where
// its energy goes. The sd of a computed value combines the published sds of the condition's inputs (vx, vy,
// omega at touchdown, e through vy at lift-off, dwell time) with the covariance of the fitted parameters,
// which is scaled by the fit's chi-square; the model's own error is not in it. The inputs' sds are those of
// single shots, and so are the results'. Allocates; thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "common/impact/fit/contact_fit.hpp"
#include "common/units/value_sd.hpp"

namespace strobe::impact {

/// Skid to grip of one condition. Times are nullopt where the ball slides throughout.
struct SkidToGrip {
  std::string name;
  Regime regime = Regime::slides;
  ValueSd dwell_s;
  std::optional<ValueSd> grip_s;       ///< the contact point sticks
  std::optional<ValueSd> slip_zero_s;  ///< the rigid contact point stops, vx + R·omega = 0
  /// From the measured velocities at both ends alone, with friction at its limit up to then: the time at
  /// which the normal impulse reaches |s|·alpha/((1 + alpha)·mu), which stops the contact point. nullopt
  /// where it does not reach it.
  std::optional<ValueSd> by_impulse_s;
  double slip_lo_mps = 0.0;      ///< computed, of the rigid contact point
  ValueSd measured_slip_lo_mps;  ///< vx + R·omega as measured
  int friction_reversals = 0;
};

/// In joules, of translation and rotation. The last four add up to computed_loss_j.
struct EnergyBalance {
  std::string name;
  ValueSd touchdown_j;
  ValueSd measured_loss_j;  ///< from the measured velocities
  ValueSd computed_loss_j;
  ValueSd normal_damping_j;  ///< dashpot, and energy left in the spring at release
  ValueSd sliding_j;
  ValueSd tangential_j;  ///< dashpot, and energy left in the spring
  ValueSd offset_j;      ///< rolling friction: the offset normal force against the spin
};

struct SkidAndEnergy {
  std::vector<SkidToGrip> skid_to_grip;
  std::vector<EnergyBalance> energy;
};

/// One entry per observation, in their order. Fails on an observation that simulate() refuses (named).
Result<SkidAndEnergy> skid_and_energy(std::span<const Observation> observations, const ContactFit& fit,
                                      const ContactFitOptions& options = {});

}  // namespace strobe::impact
