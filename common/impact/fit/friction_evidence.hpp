// Whether a fit knows that any contact slid, or that any gripped: only then does it know the friction coefficient or the
// tangential restitution of a grip, and else what they are at least. Pure; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/impact/fit/fitter.hpp"

namespace strobe::impact {

/// Of a fit at its least sum of squares, for mu and e_x: the lower end of a one-sided interval of kLimitLevel where noise
/// alone may have made a contact look as if it slid (mu) or gripped (e_x). Returns nullopt if the parameter is not fitted,
/// or such a contact is there: then it has a value.
///
/// Where all grip the sum of squares does not depend on mu, but has its least just below what the contact with the most
/// friction needs: its noise is then fitted by a little sliding. Likewise for e_x where all slide. So the likelihood
/// ratio of that least to the best fit with the parameter at its upper bound decides, the variance being that of the
/// residuals (of the clusters where they scatter). The limit is where the sum of squares has risen over that of
/// either by the square of Student's t, the lower of the two.
std::optional<double> limit_without_evidence(const Fitter& least, Parameter parameter);

}  // namespace strobe::impact
