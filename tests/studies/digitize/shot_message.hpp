// A simulated exposure as the firmware would tell of it at the shot's end, and the rig file that goes with
// the scene. Pure functions; thread-safe; they allocate.
#pragma once

#include <cstdint>
#include <strobe_msgs/shot_t.hpp>

#include "common/units/time.hpp"
#include "host/config/rig_file.hpp"
#include "sim/scene/scene.hpp"
#include "tests/studies/digitize/photographs.hpp"

namespace strobe::studies::digitize {

/// Flashes were when the sensors' edges said. `closed_ns`: on the firmware's clock, when the shutter closed; `period`:
/// as planned.
strobe_msgs::shot_t shot_message(const KnownPhotograph& known, const sim::Scene& scene, int shot_id,
                                 std::int64_t closed_ns, Duration period = milliseconds(3));

/// What a person would have written of the scene: the ball, the inclination of the plate, and a calibrated
/// scale.
struct Calibrated {
  double px_per_m = 0.0, px_per_m_sd = 0.0, ball_diameter_m = 0.0, ball_diameter_sd_m = 0.0;
};
host::RigFile rig_of(const sim::Scene& scene, const Calibrated& calibrated,
                     const std::optional<std::array<double, 3>>& viewpoint_px = {});

}  // namespace strobe::studies::digitize
