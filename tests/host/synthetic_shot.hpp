// A shot and its digitized photograph made from a known rebound: the truth that the host's assembly is held
// against. Shares no code with the host or the simulator.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

namespace strobe::host_test {

struct Bounce {
  double vx_td = 15.62, vy_td = -6.71, omega_td = 2.6;  // m/s, rad/s
  double vx_lo = 8.84, vy_lo = 5.76, omega_lo = -313.0;
  double dwell_s = 5.2e-3, distance_m = 0.0629;
};

struct Scenario {
  Bounce bounce;
  std::uint32_t seed = 1;
  double period_s = 3e-3;
  std::vector<double> intervals_s;  // repeated; empty: all are the period
  std::set<int> omitted;  // of the train before any is left out; the others are numbered without them
  int flash_count = 166;
  double touchdown_s = 0.2507;    // after the first flash
  std::map<int, double> late_us;  // flash -> how much later than planned, both lamps
  std::set<int> missing;          // flashes that gave no light
  std::set<int> doubled;
  std::set<int> unseen;                   // flashes whose image nobody digitized
  bool sensor_a = true, sensor_b = true;  // what fires; both are fitted
  bool leftwards = false, legs_named = true;
  double noise_mm = 0.2, equator_noise_rad = 0.004;
  bool noise_stated = true;
  double machine_error_s = 0.0;  // how far the machine is off its lag
  double view_before_m = 0.25, view_after_m = 0.25;
};

struct SyntheticShot {
  strobe_msgs::shot_t shot;
  strobe_msgs::frame_t frame;
  std::vector<int> image_flash;  // the flash that made each image
};

inline constexpr double kMachineLag_s = 0.310;
inline constexpr double kBallDiameter_m = 0.0651;

SyntheticShot make_shot(const Scenario& scenario);

/// From the first instant of the train to its k-th flash.
double flash_offset_s(const Scenario& scenario, int k);

/// Number of the last flash before touchdown, when all flashes are where they were planned.
int last_flash_before_touchdown(const Scenario& scenario);

}  // namespace strobe::host_test
