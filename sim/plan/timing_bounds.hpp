// How far the timing of lamps and sensors can displace an image or its time. Pure, thread-safe, no
// allocation. Draws are within kLargestNormal standard deviations of their means.
//
// lamp_delay. Both lamps' flashes come max(0, delay + z) after the pulse, without the effect max(0, z), z
//   being the jitter: earlier by at most the delay, together but for the jitter.
// lamp_jitter. A flash comes at most kLargestNormal·jitter sooner or later; so does the mean of both lamps'.
//   Sensors see when: the ball is elsewhere on its path and the frame says so. Only what the reduction makes
//   of another place on the same path is changed, not by how far the ball has moved: shift_s() is for moving
//   the flash itself, image and time, and reading again.
// sensor_delay. Its constant part moves all times alike, and a readout does not depend on where times begin.
//   What is left is the jitter, at most kLargestNormal of its standard deviations, of the mean of two also.
//   Times are whole nanoseconds: one more for rounding.
// flash_duration. The image is the mean over the flash, which the sensors see begin and which lasts d:
//   that of a flash d/2 later, all alike, so that only the train's phase moves, and by what the mean of a
//   path over d differs from its middle. That is |acceleration|·d²/24 where the path is smooth: at most (g +
//   kappa·V²)· d²/24 in flight (flight_bounds.hpp); the equator by the spin's decay c·V·|omega|·d²/24. A
//   flash within d of touchdown or lift-off sees a path whose velocity changes within it, by no more than the
//   contact's acceleration pi·(1 + e)·(1 + mu)·|vy|/dwell times the time since: counted with that
//   acceleration.
// shutter_lag. The shutter is open around the whole train, by the largest lag that there can be: nothing.
#pragma once

#include "sim/plan/flight_bounds.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

class TimingBounds {
 public:
  explicit TimingBounds(const Scene& scene);

  /// By how much flashes move, all together.
  double common_shift_s(Effect effect) const;

  /// By how much a flash moves, each on its own.
  double shift_s(Effect effect) const;

  /// Of an image `time_s` >= 0 from the surface: for flash_duration and sensor_delay.
  BoundedDisplacement of(Effect effect, const LegMotion& leg, double time_s) const;

 private:
  double delay_s_;
  double jitter_s_;
  double sensor_jitter_s_;
  double flash_s_;
  double air_pm_;
  double decay_pm_;
  double contact_pull_ps_;  ///< acceleration in contact over |vy|
};

}  // namespace strobe::sim
