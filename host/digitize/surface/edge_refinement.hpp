// A straight edge once more, by fits of a blurred step to profiles across it. Deterministic; thread-safe; allocates.
#pragma once

#include "host/digitize/surface/edge_line.hpp"

namespace strobe::digitize {

/// The edge's place, slope and standard deviations where a step fits 12 profiles or more, else `edge` as it is, less
/// certain where light saturates. A saturated side's light is not needed: the steepest rise of such an edge lies off
/// it, the step that fits what is not saturated does not.
EdgeLine refine_edge_line(const Photograph& photograph, const PlaneMap& map, const OcclusionMask& occluded,
                          const EdgeLine& edge);

}  // namespace strobe::digitize
