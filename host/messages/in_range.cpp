#include "host/messages/in_range.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace strobe::host {
namespace {

using strobe_msgs::event_t;
using strobe_msgs::flash_t;
using strobe_msgs::shot_t;
using strobe_msgs::status_t;

// 36 years of nanoseconds since a machine's start, and more events than any bench has.
constexpr std::int64_t kMax = std::int64_t{1} << 60;
constexpr std::int64_t kLatestWall_ns = 4'000'000'000'000'000'000;  // in the year 2096
constexpr double kMax_us = 1e12;

bool within(std::int64_t value) { return -kMax <= value && value <= kMax; }
bool within(std::initializer_list<std::int64_t> values) {
  return std::all_of(values.begin(), values.end(), [](std::int64_t value) { return within(value); });
}
bool instants(std::initializer_list<std::int64_t> values) {
  return std::all_of(values.begin(), values.end(),
                     [](std::int64_t value) { return value == event_t::NO_TIME || within(value); });
}
bool finite(std::initializer_list<double> values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::abs(value) <= kMax_us; });
}

}  // namespace

bool in_range(const event_t& event) {
  return within(event.sequence) &&
         instants({event.device_time_ns, event.commanded_ns, event.issue_start_ns, event.issue_end_ns});
}

bool in_range(const status_t& status) {
  const bool earlier = std::all_of(status.earlier.begin(), status.earlier.end(),
                                   [](const auto& boot) { return within(boot.last_sequence); });
  const bool wall = 0 <= status.wall_ns && status.wall_ns <= kLatestWall_ns;
  return earlier && wall &&
         within({status.last_sequence, status.mono_ns, status.boot_time_ns, status.arm_expires_ns,
                 status.queue_overflows, status.kernel_overflows});
}

bool in_range(const shot_t& shot) {
  const auto& plan = shot.plan;
  for (std::size_t i = 0; i < shot.flashes.size(); ++i) {
    const flash_t& flash = shot.flashes[i];
    if (flash.flash_index != static_cast<std::int32_t>(i) || flash.extra_edges < 0 ||
        !within(flash.commanded_ns))
      return false;
    if (!instants({flash.issue_start_ns, flash.issue_end_ns, flash.observed_a_ns, flash.observed_b_ns}))
      return false;
  }
  const bool code = std::all_of(plan.code.begin(), plan.code.end(),
                                [](const auto& flash) { return within(flash.offset_ns); });
  return code &&
         within({shot.first_sequence, shot.last_sequence, shot.start_ns, shot.queue_overflows,
                 shot.kernel_overflows, plan.period_ns, plan.shutter_open_ns, plan.gate_delay_ns,
                 plan.impact_at_ns}) &&
         instants({shot.shutter_on_ns, shot.shutter_off_ns, shot.shutter_open_ns, shot.shutter_close_ns,
                   shot.trigger_ns, shot.gate_ns}) &&
         finite({shot.lamp_delay_a_us, shot.lamp_delay_b_us, shot.late_tolerance_us});
}

}  // namespace strobe::host
