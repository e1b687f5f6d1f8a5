// Did the ball slide throughout, and with what probability? By the model: the friction that gripping needs
// less the friction available, with the uncertainty of the parameters and of the observation's inputs. As
// measured: the change of vx that rolling off needs less the measured one. Pure; thread-safe; copies the
// observation's name.
#pragma once

#include <optional>
#include <string>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

/// Of one observation. Model and measurement say different regimes within their own uncertainty near the
/// border: one rule decides what is then said. If they contradict each other, the model's regime counts as
/// unclear where the margin of its friction is within two sd of 0, the measured one where its shortfall is;
/// where neither is, the model does not describe this contact, and its regime is unclear. So never is one
/// `slides` and the other `grips`. No contradiction is a contact whose friction the model has at its limit,
/// but whose velocities tell the measured regime (regime_of()).
struct RegimeClassification {
  std::string name;
  Regime regime = Regime::slides;  ///< by the model, in view of the measured one
  // By the model; friction as impulse per mass, m/s.
  Regime predicted = Regime::slides;
  double friction_needed_mps = 0.0;  ///< |change of vx| that gripping takes
  /// mu·J; this, the margin's sd, z and the probability are absent where mu is undetermined: no contact is
  /// known to slide.
  std::optional<double> friction_available_mps;
  std::optional<double> margin_sd_mps;  ///< of needed less available: parameters and inputs together
  std::optional<double> z;  ///< (needed less available)/sd; positive slides. ±infinity for an sd of 0.
  std::optional<double> probability_slides;  ///< normal distribution of that z
  double slip_lo_predicted_mps = 0.0;
  double slip_lo_predicted_sd_mps = 0.0;
  // As measured. Slip vx + R·omega at lift-off; a ball that rolls off has none.
  double slip_lo_mps = 0.0;
  double slip_lo_sd_mps = 0.0;  ///< vx and omega as independent
  double shortfall_mps = 0.0;   ///< change of vx that rolling off needs less the measured one
  double shortfall_sd_mps = 0.0;
  /// slides: at lift-off it still slips in the direction of touchdown's slip by more than two sd, and vx
  /// changed less than rolling off needs; grips: vx changed by at least that; else unclear, or by the rule
  /// above.
  Regime measured = Regime::unclear;
};

/// Errors as for rebound_of(). `fit.covariance` is zero for parameters taken as known.
tl::expected<RegimeClassification, InputError> classify_regime(const Observation& observation,
                                                               ReboundModel model, const ModelFit& fit,
                                                               double diameter_m);

}  // namespace strobe::impact
