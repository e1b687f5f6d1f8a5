// How an effect displaces what is measured of one image. Plain values, thread-safe.
#pragma once

#include <limits>

namespace strobe::sim {

/// The `within` of an unbounded change, or of a measurement made impossible.
inline constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// Lengths on the object's scale: x along the surface in the direction of travel, y up from it; angles
/// counter-clockwise for a ball that travels to the right.
struct Displacement {
  double x_m = 0.0;
  double y_m = 0.0;
  double diameter_m = 0.0;
  double equator_rad = 0.0;
  double time_s = 0.0;  ///< of the time that the sensors give, against the image's
};

/// Value with the effect minus value without it: `by` ± `within` (all >= 0).
struct BoundedDisplacement {
  Displacement by;
  Displacement within;
};

constexpr Displacement operator+(const Displacement& a, const Displacement& b) {
  return {a.x_m + b.x_m, a.y_m + b.y_m, a.diameter_m + b.diameter_m, a.equator_rad + b.equator_rad,
          a.time_s + b.time_s};
}
constexpr BoundedDisplacement operator+(const BoundedDisplacement& a, const BoundedDisplacement& b) {
  return {a.by + b.by, a.within + b.within};
}

}  // namespace strobe::sim
