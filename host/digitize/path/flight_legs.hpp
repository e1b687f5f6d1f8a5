// The legs of a path of any number of bounces, each a curve of free flight that joins the next. Geometry only.
// Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/path/flight_curve.hpp"

namespace strobe::digitize {

struct FlightLeg {
  FlightCurve curve;
  std::vector<int> members;  ///< by x
  double weight = 0.0;       ///< sum of the members'
};

/// Legs from left to right, each of more images than chance would lead a curve through, once in a thousand
/// photographs; none if there is no such leg. A leg beside another joins it in a bounce.
std::vector<FlightLeg> flight_legs(std::span<const PathPoint> points, std::span<const int> eligible,
                                   const PathContext& context);

}  // namespace strobe::digitize
