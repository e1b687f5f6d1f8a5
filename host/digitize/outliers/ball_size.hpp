// The ball's size on a photograph, estimated from all its images. It may change steadily across the
// photograph, where the plane of flight is not square to the camera and no calibration corrects it.
// Deterministic; thread-safe; allocates.
#pragma once

#include <span>

#include "host/digitize/core/types.hpp"

namespace strobe::digitize {

struct SizeModel {
  double diameter = 0.0;  ///< plane px, at x = 0
  double slope = 0.0;     ///< per px of x
  double sd = 0.0;        ///< of the diameter where the balls are
  double spread = 0.0;    ///< sd of single balls about it, beyond what their own sds explain

  double at(double x) const { return diameter + slope * x; }
};

/// Median diameter, with the median slope from 5 outlines on (Theil 1950, Sen 1968). At least one outline.
SizeModel fit_size_model(std::span<const Outline> outlines);

/// Whether the outline's diameter is not the ball's.
bool has_wrong_size(const Outline& outline, const SizeModel& size);

}  // namespace strobe::digitize
