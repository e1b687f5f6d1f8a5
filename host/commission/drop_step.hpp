// The acceleration of free fall as photographs of flying balls show it, against that of the place: a check of
// the scale, the clock and the plate's inclination together, since g measured = g · (true scale / stated) ·
// (stated clock / true)^2.
//
// Each leg is a flight under one gravity vector and one share of the usual drag, both common to all legs,
// from a place and with a velocity of its own: Gauss-Newton on all centres, weighted by their covariances.
// Drag has the prior of common/flight (it acts upwards on a ball that falls and downwards on one that rises,
// so that a bounce tells it apart).
//
// What to expect: n images of a leg that lasts T, with centres of sd s, leave an acceleration sd of
// s·sqrt(720/n)/T^2. With s = 0.05 px at 4000 px/m a ball of 17 m/s (T = 35 ms, 12 images) gives 0.08 m/s^2,
// and its drag and lift are as large as g: a tenth of it is their uncertainty. One dropped from a metre (T =
// 0.09 and 0.12 s, 15 images at 12 ms) gives 0.008 m/s^2, with a drag of 2 % of g known to a tenth: 0.2 % of
// g in one drop. Hence drops. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <span>

#include "common/ball/ball.hpp"
#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/commission/record/step_result.hpp"

namespace strobe::commission {

struct FreeFall {
  double g_mps2 = 0.0;
  double g_sd_mps2 = 0.0;  ///< of the images and the drag; not of the scale
  /// Of the surface against the horizontal, by the direction of g, counter-clockwise as photographed.
  double inclination_rad = 0.0;
  double inclination_sd_rad = 0.0;
  double drag_share = 1.0;  ///< of the usual drag
  double chi_squared = 0.0;
  int degrees_of_freedom = 0;
  int legs = 0;
  int images = 0;
  int outliers = 0;  ///< images left out, more than 5 sd off
};

/// Frames with a surface line, a scale and times; legs of three images or more count. Where the centres
/// scatter more than they state, sds grow with them. Fails with one line if no leg can be used.
Result<FreeFall> measure_free_fall(std::span<const reduction::Frame> frames, const ball::Ball& ball,
                                   double px_per_m);

/// A scale or clock that is off by so much moves every speed by more than a series of ten shots leaves
/// uncertain.
inline constexpr double kGravityTolerance = 0.005;

/// Of g against the place's, by dropped balls. scale_share_sd: the calibration's own.
StepResult judge_gravity(const FreeFall& fall, double local_mps2, double scale_share_sd);
/// Of the plate against the rig file's inclination.
StepResult judge_inclination(const FreeFall& fall, double stated_deg);

}  // namespace strobe::commission
