// Numbers of one photograph whose truth is constant, or known: they are witnesses of scale, clock, tilt and
// lens. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

/// A number and its standard deviation, > 0.
struct Estimate {
  double value = 0.0;
  double sd = 0.0;
};

/// Each from measurements that the others do not use, but that gravity's scale is the calibration's; without
/// one it is the diameters'. Sds are the digitizing's alone, and of gravity what drag and lift are known to.
/// Absent where the photograph does not tell, and all of them without a surface line.
struct PhotographWitnesses {
  std::optional<Estimate> gravity_mps2;        ///< by the free fall of both legs
  std::optional<Estimate> diameters_px_per_m;  ///< scale by the mean diameter, were the ball's as stated
  std::optional<Estimate> surface_rad;         ///< the surface line on the photograph, counter-clockwise
  bool calibrated = false;                     ///< the frame has a scale; else gravity's is the balls'
  /// That scale, with its sd and the ball's tolerance. Absent without one, or where both are exact.
  std::optional<Estimate> stated_px_per_m;
  /// Root of the centres' chi squared over its degrees of freedom, about 1: what is not straight, such as a
  /// lens, bends the paths. Absent where their noise is not stated.
  std::optional<Estimate> path_residuals;
};

/// By the best estimator's fit, without what it left out. Some 60 fits, a few hundred microseconds. Fails as
/// reduce() does.
Result<PhotographWitnesses> photograph_witnesses(const Frame& frame);

}  // namespace strobe::reduction
