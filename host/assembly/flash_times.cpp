#include "host/assembly/flash_times.hpp"

#include <cmath>
#include <optional>

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

constexpr std::int64_t kNoTime = flash_t::NO_TIME;
// Stamps of sensor and pulse come from one clock; a microsecond or two may part them, not ten.
constexpr std::int64_t kStampTolerance_ns = 10'000;

constexpr int kLampA = strobe_msgs::coded_flash_t::LAMP_A;
constexpr int kLampB = strobe_msgs::coded_flash_t::LAMP_B;

std::int64_t rounded_ns(double us) { return std::isfinite(us) ? std::llround(us * 1e3) : 0; }

/// From pulse to flash: of the lamp that flashes, or the mean of both.
std::int64_t lamp_delay_ns(const shot_t& shot, const flash_t& flash) {
  const std::int64_t a = rounded_ns(shot.lamp_delay_a_us);
  const std::int64_t b = rounded_ns(shot.lamp_delay_b_us);
  return flash.lamps == kLampA ? a : flash.lamps == kLampB ? b : a + (b - a) / 2;
}

/// A flash of one lamp is when that lamp's sensor saw it; the other's may have seen it, too.
std::optional<std::int64_t> observed_ns(const shot_t& shot, const flash_t& flash) {
  const bool a = flash.observed_a_ns != kNoTime;
  const bool b = flash.observed_b_ns != kNoTime;
  if (a && b && flash.lamps == kLampA) return flash.observed_a_ns;
  if (a && b && flash.lamps == kLampB) return flash.observed_b_ns;
  if (a && b) return flash.observed_a_ns + (flash.observed_b_ns - flash.observed_a_ns) / 2;
  if (!a && !b) return std::nullopt;
  const std::int64_t seen = a ? flash.observed_a_ns : flash.observed_b_ns;
  const bool both_lamps = flash.lamps != kLampA && flash.lamps != kLampB;
  const bool other_fitted = a ? shot.sensor_b_fitted : shot.sensor_a_fitted;
  // One sensor that stands for both lamps: the other lamp's flash comes by so much earlier or later.
  if (!both_lamps || other_fitted) return seen;
  return seen + lamp_delay_ns(shot, flash) - rounded_ns(a ? shot.lamp_delay_a_us : shot.lamp_delay_b_us);
}

bool any_observed(const shot_t& shot) {
  for (const flash_t& flash : shot.flashes) {
    if (observed_ns(shot, flash)) return true;
  }
  return false;
}

ObservedFlash seen_flash(const shot_t& shot, const flash_t& flash, std::int64_t time_ns, bool measured) {
  ObservedFlash seen;
  seen.index = flash.flash_index;
  seen.time_ns = time_ns;
  seen.time_sd_s = measured ? kSensorTimeSd_s : kIssuedTimeSd_s;
  const double late_us =
      static_cast<double>(time_ns - flash.commanded_ns - lamp_delay_ns(shot, flash)) * 1e-3;
  seen.late = late_us > shot.late_tolerance_us;
  seen.doubled = flash.extra_edges > 0;
  seen.sensor_silent = (shot.sensor_a_fitted && flash.lamps != kLampB && flash.observed_a_ns == kNoTime) ||
                       (shot.sensor_b_fitted && flash.lamps != kLampA && flash.observed_b_ns == kNoTime);
  seen.before_its_pulse =
      flash.issue_start_ns == kNoTime || time_ns < flash.issue_start_ns - kStampTolerance_ns;
  return seen;
}

}  // namespace

FlashTimes flash_times(const shot_t& shot) {
  FlashTimes times;
  times.measured = any_observed(shot);
  for (const flash_t& flash : shot.flashes) {
    std::optional<std::int64_t> time = observed_ns(shot, flash);
    if (!times.measured && flash.issue_end_ns != kNoTime)
      time = flash.issue_end_ns + lamp_delay_ns(shot, flash);
    if (!time) {
      times.missing.push_back(flash.flash_index);
      continue;
    }
    if (!times.seen.empty() && *time <= times.seen.back().time_ns) times.in_order = false;
    times.seen.push_back(seen_flash(shot, flash, *time, times.measured));
  }
  return times;
}

}  // namespace strobe::host
