// A spin's decay in flight, known in its order only: what another decay than the assumed one makes of the equator's
// angles. Part of the reduction, not of its interface. Thread-safe; no allocation.
#pragma once

#include <vector>

#include "common/reduction/spin_line.hpp"

namespace strobe::reduction {

/// Cost of the readings' distances from the line, in variances up to kCostLimit each, with the decay that suits it best,
/// from none to three times `decay_per_s`, with which the readings were stretched: a faster spin bends the angle more,
/// which is no evidence against it as long as nobody knows the decay well. Of a line
/// that left out what a bend took away from it the one through all readings counts, if it costs less.
double cost_at_any_decay(const std::vector<EquatorReading>& readings, const SpinLine& line,
                         double decay_per_s);

/// Takes out of the residuals of `fit` what the likeliest decay explains of them, the decay being known to
/// `decay_sd_per_s` before, and adds what it takes to their leverage. `line` is the readings' least squares line. The
/// spin and its variance stay.
/// Source: linear model with a random effect, e.g. Koch, Parameter Estimation and Hypothesis Testing, 3.6: of a
/// parabola's coefficient -omega delta / 2, delta the decay's error.
void allow_for_decay(const std::vector<EquatorReading>& readings, const SpinLine& line, double decay_sd_per_s,
                     SpinFit& fit);

}  // namespace strobe::reduction
