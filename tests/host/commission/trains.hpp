// Dry trains as a rig would report them, with faults.
#pragma once

#include <cstdint>
#include <random>
#include <strobe_msgs/shot_t.hpp>

#include "common/shot/shot_plan.hpp"

namespace strobe::commission_test {

struct TrainFaults {
  double delay_us = 12.0;  ///< of lamp A; B flashes 0.1 us later
  double jitter_us = 1.0;
  double call_us = 1.5;  ///< how long each set-values call takes; the line changes at its begin
  bool swapped = false;  ///< sensors
  bool dark = false;
  int missing_every = 0;  ///< 0: none
  int double_every = 0;
  int late_every = 0;
  int cross_talk_every = 0;
};

inline strobe_msgs::shot_t train(Lamps lamps, const TrainFaults& faults, unsigned seed = 1,
                                 int flashes = 100) {
  std::mt19937 random(seed);
  std::normal_distribution<double> jitter(0.0, faults.jitter_us);
  const auto ns = [](double us) { return static_cast<std::int64_t>(1e3 * us); };
  const auto each = [](int k, int every) { return every > 0 && k % every == every - 1; };
  strobe_msgs::shot_t shot{};
  shot.boot_id = 7;
  shot.shot_id = 1;
  shot.plan.dry = 1;
  shot.sensor_a_fitted = shot.sensor_b_fitted = 1;
  shot.lamp_delay_a_us = shot.lamp_delay_b_us = 12.0;
  shot.late_tolerance_us = 100.0;
  for (int k = 0; k < flashes; ++k) {
    strobe_msgs::flash_t flash{};
    flash.flash_index = k;
    flash.lamps = static_cast<std::int8_t>(lamps);
    flash.commanded_ns = 1'000'000'000 + 3'000'000LL * k;
    flash.issue_start_ns = flash.commanded_ns + 20;
    flash.issue_end_ns = flash.issue_start_ns + ns(faults.call_us);
    flash.observed_a_ns = flash.observed_b_ns = strobe_msgs::flash_t::NO_TIME;
    const bool flashes_now = !faults.dark && !each(k, faults.missing_every);
    const double late_us = each(k, faults.late_every) ? 400.0 : 0.0;
    const auto seen = [&](double delay_us) {
      return flash.issue_start_ns + ns(delay_us + jitter(random) + late_us);
    };
    if (flashes_now && has_a(lamps))
      (faults.swapped ? flash.observed_b_ns : flash.observed_a_ns) = seen(faults.delay_us);
    if (flashes_now && has_b(lamps))
      (faults.swapped ? flash.observed_a_ns : flash.observed_b_ns) = seen(faults.delay_us + 0.1);
    if (each(k, faults.cross_talk_every))
      (has_a(lamps) ? flash.observed_b_ns : flash.observed_a_ns) = seen(faults.delay_us);
    flash.extra_edges = each(k, faults.double_every) ? 1 : 0;
    shot.flashes.push_back(flash);
  }
  shot.flash_count = flashes;
  return shot;
}

}  // namespace strobe::commission_test
