// Wider intervals than the stated one. A stated sd is the half width of the interval that holds 68.27 % of
// the errors; where the noise was estimated it is s·t(68.27 %, nu), s from the levels as estimated, and the
// ratio of the two tells nu. Thread-safe.
#pragma once

#include "common/reduction/readout.hpp"

namespace strobe::test {

/// Standard deviations without Student's factor: of the primary numbers, e, mu and the dwell time, by hand
/// from the readout's covariance. Absent without one.
reduction::Quantities plain_sd(const reduction::Readout& readout);

/// Half width of the interval that holds 95.45 % of the errors, over the stated sd: 2 for known noise.
/// `factor` is the stated sd over the plain one.
double widening(double factor);

}  // namespace strobe::test
