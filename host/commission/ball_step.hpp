// What thrown balls say of flashes, noise and machine. Each limit is wide enough that a good rig exceeds it
// less than once in 10,000 runs (4 sd of a normal, or as said), and no narrower than what matters. Pure;
// allocates; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/reduction/readout.hpp"
#include "host/commission/record/step_result.hpp"

namespace strobe::commission {

/// One thrown ball, as its step collects them.
struct BallShot {
  std::optional<std::string> rejected;
  reduction::Readout readout;
  int images = 0;                ///< of the ball, measured
  int centres = 0;               ///< degrees of freedom of the centres' residuals
  std::optional<double> lag_s;   ///< from the trigger to the plate
  std::optional<double> spot_m;  ///< of touchdown on the photograph, along the surface
  int gate_edges = 0;
};

/// Whether each throw brought one ball: by the gate where there is one, and by the images.
StepResult judge_throws(std::span<const BallShot> shots, bool gate_fitted);
/// Whether the code of the flashes was found on each photograph.
StepResult judge_flashes(std::span<const BallShot> shots);
/// Whether centres are as far off their flights as they state: chi squared of all shots over its degrees of
/// freedom.
StepResult judge_noise(std::span<const BallShot> shots);
/// Mean lag against the rig file's, and the spread of lag, spot and speed.
StepResult judge_repeatability(std::span<const BallShot> shots, std::optional<double> lag_s,
                               double view_width_m);

}  // namespace strobe::commission
