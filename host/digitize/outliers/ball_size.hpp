// The size that the ball's images agree on; it may change steadily across the photograph, where the plane of
// flight is not square to the view and no calibration says so. Deterministic; thread-safe; allocates.
#pragma once

#include <span>

#include "host/digitize/core/types.hpp"

namespace strobe::digitize {

struct SizeModel {
  double diameter = 0.0;  ///< plane px, at x = 0
  double growth = 0.0;    ///< per px of x
  double sd = 0.0;        ///< of the diameter where the balls are

  double at(double x) const { return diameter + growth * x; }
};

/// Median, and with 5 outlines or more the median slope (Theil 1950, Sen 1968). At least one outline.
SizeModel fit_size_model(std::span<const Outline> outlines);

/// Whether a diameter is not the ball's.
bool wrong_size(const Outline& outline, const SizeModel& size);

}  // namespace strobe::digitize
