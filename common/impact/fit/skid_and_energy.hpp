// What the fitted contact mechanics say of each measured condition: when the ball stops skidding, and where
// its energy goes, with uncertainties. The sd of a computed value joins the published sd of the condition's
// inputs (vx, vy, omega at touchdown, e through vy at lift-off, dwell time) with the covariance of the
// fitted parameters (which carries the misfit of the fit, by its chi-square); what the model itself leaves
// out is not in it. The sd of inputs are those of single shots, so a value's sd is a shot's; a mean's is
// less by the root of the number of shots. Allocates; thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "common/impact/fit/contact_fit.hpp"

namespace strobe::impact {

struct Uncertain {
  double value = 0.0;
  double sd = 0.0;
};

/// Skid to grip of one condition. Empty times: slides throughout.
struct SkidToGrip {
  std::string name;
  Regime regime = Regime::slides;
  Uncertain dwell_s;
  std::optional<Uncertain> grip_s;       ///< skidding ends: the contact point sticks
  std::optional<Uncertain> slip_zero_s;  ///< the rigid contact point stops, vx + R·omega = 0
  /// From the velocities measured at both ends alone, friction at its limit until then: the impulse that
  /// stops the contact point, |s|·alpha/(1 + alpha) per mass, as a share of mu·J, turned into a time by the
  /// normal force's course. Empty where that share passes 1: slides throughout.
  std::optional<Uncertain> by_impulse_s;
  double slip_lo_mps = 0.0;        ///< computed, of the rigid contact point
  Uncertain measured_slip_lo_mps;  ///< vx + R·omega as measured
  int friction_reversals = 0;
};

/// In joules, of translation and rotation. computed parts sum to computed_loss.
struct EnergyBalance {
  std::string name;
  Uncertain touchdown_j;
  Uncertain measured_loss_j;  ///< from the measured velocities
  Uncertain computed_loss_j;
  Uncertain normal_damping_j;  ///< dashpot, and what is left in the spring at release
  Uncertain sliding_j;
  Uncertain tangential_j;  ///< dashpot and what is left in the spring
  Uncertain offset_j;      ///< rolling friction: the offset normal force against the spin
};

struct ContactConclusions {
  std::vector<SkidToGrip> skid_to_grip;
  std::vector<EnergyBalance> energy;
};

/// For each observation of the fit, in its order. Fails as fit_contact does.
Result<ContactConclusions> conclude(std::span<const ContactObservation> observations, const ContactFit& fit,
                                    const ContactFitOptions& options = {});

}  // namespace strobe::impact
