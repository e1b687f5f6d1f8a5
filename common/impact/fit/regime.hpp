// Did the ball slide throughout, and how sure is that? Once from the model: the friction that gripping needs
// against what there is, with the uncertainty of the parameters and of the observation's inputs. Once as
// measured: the friction that acted against what rolling off needs. Pure; thread-safe; compare_regimes()
// allocates.
#pragma once

#include <optional>
#include <string>

#include "common/impact/fit/model_fit.hpp"

namespace strobe::impact {

struct RegimeJudgement {
  std::string name;
  // By the model. Friction impulses per mass, m/s.
  Regime predicted = Regime::slides;
  double friction_needed_mps = 0.0;     ///< |change of vx| that gripping takes
  double friction_available_mps = 0.0;  ///< mu·J
  double margin_sd_mps = 0.0;           ///< of needed less available: parameters and inputs together
  double z = 0.0;  ///< (needed less available)/sd; positive slides. ±infinity for an sd of 0.
  double probability_slides = 0.0;  ///< normal distribution of that z
  double slip_lo_predicted_mps = 0.0;
  double slip_lo_predicted_sd_mps = 0.0;
  // As measured. Slip vx + R·omega at lift-off; a ball that rolls off has none.
  double slip_lo_mps = 0.0;
  double slip_lo_sd_mps = 0.0;  ///< vx and omega as independent
  double shortfall_mps = 0.0;   ///< rolling off needs that much more change of vx than there was
  double shortfall_sd_mps = 0.0;
  /// A ball that slid throughout does both: it still slips the way it did at touchdown, and it was braked
  /// less than rolling off needs. slides: slips by more than two sd, and was braked less; grips: was not
  /// braked less.
  Regime measured = Regime::unclear;
};

/// Errors as for rebound_of(). `fit.covariance` is zero for parameters taken as known.
tl::expected<RegimeJudgement, InputError> judge_regime(const Observation& observation, ReboundModel model,
                                                       const ModelFit& fit, double diameter_m);

}  // namespace strobe::impact
