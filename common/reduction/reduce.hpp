// From a digitized frame to a readout: the estimators behind one interface.
// Deterministic, no I/O; thread-safe; allocates, so not for the real-time path.
#pragma once

#include <optional>
#include <string_view>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "common/result.hpp"

namespace strobe::reduction {

enum class Estimator {
  best,       ///< every airborne image of a leg, gravity, common scale and surface line, with covariance
  two_point,  ///< slope between the two images nearest to the impact (thesis, tilt corrected), measured times
  legacy,     ///< the thesis's program with its quirks, for comparison with old results
};

constexpr std::optional<Estimator> estimator_from_name(std::string_view text) {
  if (text == "best") return Estimator::best;
  if (text == "two-point") return Estimator::two_point;
  if (text == "legacy") return Estimator::legacy;
  return std::nullopt;
}

/// A readout of the frame. Numbers that cannot be had are absent and the flags say why.
/// Fails only for a frame that is not one: no positive diameter, fewer than two surface points, non-finite
/// coordinates, images out of order of time. The message names the field.
Result<Readout> reduce(const Frame& frame, Estimator estimator);

/// How well straight flight under gravity explains the airborne images at their times.
struct FlightFit {
  double chi_squared =
      0.0;  ///< sum of squared residuals in units of the noise (1 px where the frame states none)
  int degrees_of_freedom = 0;
  double dwell_time_s = 0.0;      ///< touchdown to lift-off
  double dwell_distance_m = 0.0;  ///< along the surface
  double vx_td_mps = 0.0;
  double vx_lo_mps = 0.0;
};

/// The same fit as Estimator::best without its readout; for choosing which flash made which image.
/// Fails as reduce() does, and where a leg has fewer than two airborne images.
Result<FlightFit> fit_flight(const Frame& frame);

}  // namespace strobe::reduction
