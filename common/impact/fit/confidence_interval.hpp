// Confidence intervals of fitted parameters from the profile of the sum of squares: the values at which the best fit of
// the others is worse by a step. Unlike value ± t sd it follows the kinks between regimes and the bounds. The step is
// Student's t squared, times what the residuals say that the parameter's variance is over what the weights say (R.
// Chandler and S. Bate, Biometrika 94, 2007), so that the interval is value ± t sd where the model is linear.
// Deterministic; thread-safe; allocates; some ten fits from near values for each end.
#pragma once

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

struct Interval {
  std::optional<double>
      lower;  ///< absent where the profile stays below the step down to the parameter's bound
  std::optional<double> upper;
};

/// `sd` sets the step, the sum of squares at `sd` from the value of a linear model; `t` the interval's ends in sds. `unit`: the
/// rise of the sum of squares at one sd.
Interval profile_interval(const Fitter& least, Parameter parameter, double sd, double unit, double t);

}  // namespace strobe::impact
