// What photographs of thrown and dropped balls say of scale, camera, plate, noise and machine. Each limit is wide enough that
// a good rig exceeds it less than once in 10,000 runs (4 sd of a normal, or as said), and no narrower than what matters.
// Pure; allocates; thread-safe.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "host/commission/balls/free_fall.hpp"
#include "host/commission/balls/scale_check.hpp"
#include "host/commission/core/step_result.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::commission {

/// A scale or clock that is off by so much moves every speed by more than a series of ten shots leaves uncertain.
inline constexpr double kGravityTolerance = 0.005;
/// 3 sd of two numbers that should be the same, at worst, when the drops are as good as this.
inline constexpr double kMaxGravitySd = 0.0012;

/// Of g against the place's, by dropped balls. scale_share_sd: the calibration's own.
StepResult judge_gravity(const std::string& id, const FreeFall& fall, double local_mps2,
                         double scale_share_sd);
/// Of the plate against the rig file's inclination.
StepResult judge_inclination(const std::string& id, const FreeFall& fall, double stated_deg);

/// The ball's size against scale and diameter; diameter_share_sd and scale_share_sd as the rig file states them.
StepResult judge_scale(const std::string& id, const ScaleCheck& check, double diameter_share_sd,
                       double scale_share_sd);
/// Change of the ball's size over the photograph.
StepResult judge_squareness(const std::string& id, const ScaleCheck& check);

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
StepResult judge_throws(const std::string& id, std::span<const BallShot> shots, bool gate_fitted);
/// Whether the code of the flashes was found on each photograph.
StepResult judge_flashes(const std::string& id, std::span<const BallShot> shots);
/// Whether centres are as far off their flights as they state: chi squared of all shots over its degrees of freedom.
StepResult judge_noise(const std::string& id, std::span<const BallShot> shots);
/// Mean lag against the rig file's, and the spread of lag, spot and speed.
StepResult judge_repeatability(const std::string& id, std::span<const BallShot> shots,
                               std::optional<double> lag_s, double view_width_m);

}  // namespace strobe::commission
