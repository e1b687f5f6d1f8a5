#include "host/assembly/flash_times.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/digitize/core/statistics.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

// Stamps of sensor and pulse come from one clock; a microsecond or two may part them, not ten.
constexpr Duration kStampTolerance = microseconds{10};

constexpr int kLampA = strobe_msgs::coded_flash_t::LAMP_A;
constexpr int kLampB = strobe_msgs::coded_flash_t::LAMP_B;

Duration rounded(double us) { return Duration{std::isfinite(us) ? std::llround(us * 1e3) : 0}; }

/// From pulse to flash: of the lamp that flashes, or the mean of both.
Duration lamp_delay(const shot_t& shot, const flash_t& flash) {
  const Duration a = rounded(shot.lamp_delay_a_us);
  const Duration b = rounded(shot.lamp_delay_b_us);
  return flash.lamps == kLampA ? a : flash.lamps == kLampB ? b : a + (b - a) / 2;
}

/// A flash of one lamp is when that lamp's sensor saw it; the other's may have seen it, too. kNoTime: none
/// did.
MonoTime observed(const shot_t& shot, const flash_t& flash) {
  const MonoTime a = from_ns(flash.observed_a_ns), b = from_ns(flash.observed_b_ns);
  if (known(a) && known(b)) return flash.lamps == kLampA ? a : flash.lamps == kLampB ? b : a + (b - a) / 2;
  const MonoTime seen = known(a) ? a : b;
  if (!known(seen)) return kNoTime;
  const bool both_lamps = flash.lamps != kLampA && flash.lamps != kLampB;
  const bool other_fitted = known(a) ? shot.sensor_b_fitted : shot.sensor_a_fitted;
  // One sensor that stands for both lamps: the other lamp's flash comes by so much earlier or later.
  if (!both_lamps || other_fitted) return seen;
  return seen + lamp_delay(shot, flash) - rounded(known(a) ? shot.lamp_delay_a_us : shot.lamp_delay_b_us);
}

bool any_observed(const shot_t& shot) {
  return std::any_of(shot.flashes.begin(), shot.flashes.end(),
                     [&](const flash_t& flash) { return known(observed(shot, flash)); });
}

ObservedFlash seen_flash(const shot_t& shot, const flash_t& flash, MonoTime time) {
  ObservedFlash seen;
  seen.index = flash.flash_index;
  seen.time = time;
  const Duration lateness = time - from_ns(flash.commanded_ns) - lamp_delay(shot, flash);
  seen.late = to_microseconds(lateness) > shot.late_tolerance_us;
  seen.doubled = flash.extra_edges > 0;
  seen.sensor_silent =
      (shot.sensor_a_fitted && flash.lamps != kLampB && !known(from_ns(flash.observed_a_ns))) ||
      (shot.sensor_b_fitted && flash.lamps != kLampA && !known(from_ns(flash.observed_b_ns)));
  const MonoTime issued = from_ns(flash.issue_start_ns);
  seen.before_its_pulse = !known(issued) || time < issued - kStampTolerance;
  return seen;
}

// The sd of a median absolute deviation of so many is a fifth of it: 1.17 over the root of their number.
constexpr std::size_t kEnoughIntervals = 34;

/// Seconds from the pulse's end to the stamp, over what the lamp's delay says.
std::vector<double> late_by_s(const shot_t& shot) {
  std::vector<double> late;
  late.reserve(shot.flashes.size());
  for (const flash_t& flash : shot.flashes) {
    const MonoTime time = observed(shot, flash), issued = from_ns(flash.issue_end_ns);
    if (known(time) && known(issued)) late.push_back(to_seconds(time - issued - lamp_delay(shot, flash)));
  }
  return late;
}

double sensor_time_sd_of(const shot_t& shot) {
  std::vector<double> late = late_by_s(shot);
  if (late.size() < kEnoughIntervals) return kSensorTimeSd_s;
  const double middle = digitize::median(late);
  for (double& x : late) x = std::abs(x - middle);
  return std::clamp(digitize::kSdOverMad * digitize::median(std::move(late)), kMinSensorTimeSd_s,
                    kSensorTimeSd_s);
}

}  // namespace

FlashTimes flash_times(const shot_t& shot, std::optional<double> sensor_time_sd_s) {
  FlashTimes times;
  times.measured = any_observed(shot);
  for (const flash_t& flash : shot.flashes) {
    MonoTime time = observed(shot, flash);
    const MonoTime issued = from_ns(flash.issue_end_ns);
    if (!times.measured && known(issued)) time = issued + lamp_delay(shot, flash);
    if (!known(time)) {
      times.missing.push_back(flash.flash_index);
      continue;
    }
    if (!times.seen.empty() && time <= times.seen.back().time) times.in_order = false;
    times.seen.push_back(seen_flash(shot, flash, time));
  }
  const double by_sensors = sensor_time_sd_s ? *sensor_time_sd_s : sensor_time_sd_of(shot);
  for (ObservedFlash& flash : times.seen) flash.time_sd_s = times.measured ? by_sensors : kIssuedTimeSd_s;
  return times;
}

}  // namespace strobe::host
