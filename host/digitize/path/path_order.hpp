// A path's images one after another in one of its two directions, and which of its bounces they are told of.
// Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "common/shot/leg.hpp"
#include "host/digitize/path/path.hpp"

namespace strobe::digitize {

struct PathOrder {
  std::vector<int> sequence;  ///< in order of time
  std::vector<std::optional<Leg>>
      leg;  ///< of the sequence, at the bounce; absent for other legs' and ambiguous images
  std::vector<std::vector<int>> legs;  ///< in order of time
  std::vector<int> incoming;           ///< to the bounce; empty without a bounce
  int bounces = 0;
  int bounce = 0;        ///< whose legs are told, from 1; 0 without
  double towards = 1.0;  ///< +1: travels to greater x
};

/// The path from its first leg on, or `reversed`. The bounce is the one asked for, if there is one; else the
/// first with two images or more on either side, which give a velocity; else the first.
PathOrder path_order(std::span<const PathPoint> points, const Path& path, bool reversed,
                     std::optional<int> bounce);

/// Whether flights (in order of time) become lower, +1, or higher, -1; 0 where that is not seen.
int falling_heights(std::span<const PathPoint> points, const std::vector<std::vector<int>>& legs,
                    double diameter_px);

}  // namespace strobe::digitize
