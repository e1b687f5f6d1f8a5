// How well the flashes of one shot came: what a dry shot is fired for, and a check of any other.
// No I/O; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "host/session/delay_calibration.hpp"

namespace strobe::host {

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

TrainReport train_report(const strobe_msgs::shot_t& shot);

/// Lines of text for a person.
std::vector<std::string> describe(const TrainReport& report);

/// Whether every planned flash came once, on time and was seen by each fitted sensor.
bool sound(const TrainReport& report);

/// {"shot_id":…,"dry":true,"planned":…, …} on one line; keys in fixed order, absent counts null.
std::string train_report_json(const TrainReport& report, int shot_id);

}  // namespace strobe::host
