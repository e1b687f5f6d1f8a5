// What a shot shows of the bench's own delays, as values for the rig file. No I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

namespace strobe::host {

struct CalibratedDelay {
  int count = 0;
  double mean = 0.0;
  double sd = 0.0;       ///< from one to the next
  double mean_sd = 0.0;  ///< of the mean
};

/// From the call that sets the line to the flash as its sensor saw it: lamp and sensor together, less the
/// sensor's delay as configured. Flashes that came doubled, or whose call took too long to tell when the line
/// changed, are left out; so is a lamp with fewer than two others.
struct DelayCalibration {
  std::optional<CalibratedDelay> lamp_a_us;
  std::optional<CalibratedDelay> lamp_b_us;
  std::optional<double> opening_lag_ms;  ///< by the shutter's contact
  std::optional<double> closing_lag_ms;
};

DelayCalibration delay_calibration(const strobe_msgs::shot_t& shot);

/// Lines of TOML to paste into the rig file, each value with its uncertainty as a comment; none: nothing to
/// say.
std::vector<std::string> calibration_lines(const DelayCalibration& calibration);

}  // namespace strobe::host
