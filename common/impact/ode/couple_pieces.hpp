// Without an offset a contact's segments are as long as its closed forms go, and no couple is resolved on their nodes. What
// the first bit of an offset would do, an integral along a known motion, needs pieces that resolve it: where the spin turns
// round, and where the footprint reaches its full size. Pure, no allocation: thread-safe, real-time safe.
#pragma once

#include "common/impact/ode/segment_partials.hpp"

namespace strobe::impact::detail {

/// Carries the variational equations along a segment of a contact without an offset, in pieces that
/// resolve the couple of an offset to `tolerance`.
void advance_in_pieces(VariationalEquations& equations, const CollocationConstants& constants,
                       const Segment& segment, double tolerance);

}  // namespace strobe::impact::detail
