// Straight flight under known gravity through the images of one leg: the cheap inner loop of the matching.
// No I/O, no allocation; thread-safe.
#pragma once

#include <span>

#include "host/assembly/track.hpp"

namespace strobe::host {

/// along(t) = along_px + v_along_px (t - middle_s) + gravity (t - middle_s)^2 / 2, and up(t) likewise.
struct LegFit {
  int count = 0;             ///< images; a velocity needs 2
  double chi_squared = 0.0;  ///< both coordinates, in units of the noise; 2 count - 4 degrees of freedom
  double middle_s = 0.0;     ///< mean of the times
  double along_px = 0.0;
  double up_px = 0.0;
  double v_along_px = 0.0;  ///< px/s, at middle_s
  double v_up_px = 0.0;
  double spread_s2 = 0.0;  ///< sum of squared times about middle_s

  bool has_velocity() const { return count >= 2 && spread_s2 > 0.0; }
  /// Factors of the noise: standard deviation of a velocity component, and of a coordinate at a time.
  double velocity_factor() const;
  double position_factor(double time_s) const;
};

/// Fits images[i] at times_s[i]. sd_px > 0 is the noise of each coordinate.
LegFit fit_leg(std::span<const TrackPoint> images, std::span<const double> times_s, const Track& track);

/// When the centre crosses the height of one radius on the fitted path, and where; only with a velocity that
/// goes towards (incoming) or away from (rebound) the surface.
struct Crossing {
  double time_s = 0.0;
  double along_px = 0.0;
  double v_along_px = 0.0;
  double v_up_px = 0.0;
};
std::optional<Crossing> crossing(const LegFit& fit, const Track& track);

}  // namespace strobe::host
