// When each flash of a shot was, from what the sensors saw of it. No I/O; thread-safe.
#pragma once

#include <optional>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "common/units/time.hpp"

namespace strobe::host {

/// A flash that gave light. Its time: the mean of both sensors' stamps, or the one's that
/// fired (of a flash of one lamp: its own sensor's). Where one sensor stands for both lamps, the difference
/// of their delays is allowed for.
struct ObservedFlash {
  int index = 0;  ///< flash_t.flash_index
  MonoTime time;
  double time_sd_s = 0.0;
  bool late = false;              ///< observed - commanded - lamp delay beyond the rig's tolerance
  bool doubled = false;           ///< further sensor edges before the next flash
  bool sensor_silent = false;     ///< a fitted sensor did not see the flash of its lamp
  bool before_its_pulse = false;  ///< seen before it was issued: not plausible
};

/// The flashes of a shot that can have made an image, in order of time.
struct FlashTimes {
  std::vector<ObservedFlash> seen;
  std::vector<int> missing;  ///< indices of planned flashes that no sensor saw, ascending
  /// false: no sensor saw anything; times are issued times plus the lamps' mean delay.
  bool measured = false;
  bool in_order = true;  ///< times rise with the index
};

/// Most that the standard deviation of a flash time can be that a sensor's edge gives, where the shot does
/// not tell less: kernel stamp and photodiode. [s]
inline constexpr double kSensorTimeSd_s = 2e-6;
/// The least: a photodiode's rise. [s]
inline constexpr double kMinSensorTimeSd_s = 10e-9;
/// The same where no sensor saw it: a lamp's delay differs from its mean from flash to flash and with age.
/// [s]
inline constexpr double kIssuedTimeSd_s = 20e-6;

/// sensor_time_sd_s: of a flash time that sensors give. Absent: what the shot itself tells. From pulse to
/// stamp it takes the lamp's delay, which differs from flash to flash, and the stamp's error, which is
/// independent of that: the stamps' sd is no larger than these intervals', of which half the flashes give a
/// robust estimate (median absolute deviation; Rousseeuw, Croux, J. Am. Stat. Assoc. 88, 1993), nor than
/// kSensorTimeSd_s.
FlashTimes flash_times(const strobe_msgs::shot_t& shot, std::optional<double> sensor_time_sd_s = {});

}  // namespace strobe::host
