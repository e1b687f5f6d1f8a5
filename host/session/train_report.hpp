// How well the flashes of one shot came, what a dry shot is fired for and a check of any other; and what they
// show of the bench's own delays, as values for the rig file. No I/O; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "host/assembly/flash_times.hpp"

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
  double stated_a_us = 0.0, stated_b_us = 0.0;  ///< as the rig file says
  std::optional<double> opening_lag_ms;         ///< by the shutter's contact
  std::optional<double> closing_lag_ms;
};

DelayCalibration delay_calibration(const strobe_msgs::shot_t& shot);

/// Lines of TOML to paste into the rig file, each value with its uncertainty as a comment; none: nothing to
/// say.
std::vector<std::string> calibration_lines(const DelayCalibration& calibration);

struct MeanSdMax {
  int count = 0;
  double mean = 0.0;
  double sd = 0.0;       ///< population
  double largest = 0.0;  ///< of the magnitude
};

/// Flashes that were not as they should be, numbered as fired from 0; ascending.
struct FlashFaults {
  std::vector<int> late;  ///< beyond the rig's tolerance
  std::vector<int> doubled;
  std::vector<int> missing;                   ///< seen by no sensor
  std::vector<int> unseen_by_a, unseen_by_b;  ///< by a fitted sensor, of its own lamp
};

struct TrainReport {
  int planned = 0;
  int planned_a = 0;  ///< of lamp A, alone or with the other
  int planned_b = 0;
  int issued = 0;
  std::optional<int> seen_by_a;  ///< of lamp A's flashes; absent: no such sensor
  std::optional<int> seen_by_b;
  int late = 0;  ///< beyond the rig's tolerance
  int doubled = 0;
  MeanSdMax issue_lateness_us;  ///< issue_end - commanded
  MeanSdMax lamp_delay_us;      ///< flash time - issue_end, flashes that a sensor saw
  MeanSdMax skew_us;            ///< sensor A - sensor B, flashes of both lamps that both saw
  DelayCalibration calibration;
  FlashFaults faults;
};

/// times: of the shot's flashes.
TrainReport train_report(const strobe_msgs::shot_t& shot, const FlashTimes& times);
inline TrainReport train_report(const strobe_msgs::shot_t& shot) {
  return train_report(shot, flash_times(shot));
}

/// Lines of text for a person.
std::vector<std::string> describe(const TrainReport& report);

/// Whether every planned flash came once, on time and was seen by each fitted sensor.
bool sound(const TrainReport& report);

/// {"shot_id":…,"dry":true,"planned":…, …}; keys in fixed order, absent counts null.
nlohmann::ordered_json train_report_json(const TrainReport& report, int shot_id);

}  // namespace strobe::host
