// Light on a line of pixels down across a nearly level edge. Deterministic; thread-safe; no allocation.
#pragma once

#include <array>
#include <optional>

#include "host/digitize/surface/hough_lines.hpp"

namespace strobe::digitize {

inline constexpr int kProfileHalfReach_px = 10;
inline constexpr int kProfileColumns = 5;  ///< averaged for one profile; odd
inline constexpr int kMaxProfiles = 240;   ///< along an edge
/// Of the level of saturation: noise and compression leave saturated pixels a little below it.
inline constexpr double kSaturatedShare = 0.985;

struct EdgeSamples {
  int top = 0;  ///< row of the first
  std::array<double, 2 * kProfileHalfReach_px + 1> intensity{};
};

/// How many profiles are taken across an edge that crosses the photograph, and the middle column of each.
int profile_count(const Photograph& photograph);
int profile_column(const Photograph& photograph, int profile);

/// Means over kProfileColumns, from the edge's row upwards and downwards. Returns nullopt where the edge is
/// occluded or not on the photograph. A mean with a saturated pixel in it is one: kSaturatedShare of saturation or
/// more.
std::optional<EdgeSamples> samples_across(const Photograph& photograph, const OcclusionMask& occluded,
                                          int column, double row);

}  // namespace strobe::digitize
