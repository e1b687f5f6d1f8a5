#include "host/session/delay_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/reduction/running_statistics.hpp"
#include "common/units/time.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

/// How long the call took that set the line. Returns nullopt if there was none.
std::optional<Duration> call(const flash_t& flash) {
  const MonoTime start = from_ns(flash.issue_start_ns), end = from_ns(flash.issue_end_ns);
  return known(start) && known(end) ? std::optional(end - start) : std::nullopt;
}

/// An interrupted call does not show when the line changed. Longest other one: twice the shortest, and 1 us.
Duration longest_call(const shot_t& shot) {
  std::optional<Duration> shortest;
  for (const flash_t& flash : shot.flashes) {
    if (const auto took = call(flash)) shortest = std::min(shortest.value_or(*took), *took);
  }
  return 2 * shortest.value_or(Duration{}) + microseconds{1};
}

std::optional<CalibratedDelay> lamp_delay_us(const shot_t& shot, int lamp, std::int64_t flash_t::*observed) {
  reduction::RunningStatistics series;
  const Duration longest = longest_call(shot);
  for (const flash_t& flash : shot.flashes) {
    const auto took = call(flash);
    const MonoTime seen = from_ns(flash.*observed);
    if ((flash.lamps & lamp) == 0 || !took || *took > longest || !known(seen) || flash.extra_edges > 0)
      continue;
    series.add(to_microseconds(seen - from_ns(flash.issue_end_ns)));
  }
  if (series.count() < 2) return std::nullopt;
  const auto n = static_cast<double>(series.count());
  const double sd = series.sample_sd();
  return CalibratedDelay{static_cast<int>(series.count()), series.mean(), sd, sd / std::sqrt(n)};
}

std::optional<double> lag_ms(MonoTime seen, MonoTime line) {
  if (!known(seen) || !known(line)) return std::nullopt;
  return static_cast<double>((seen - line).count()) * 1e-6;
}

std::string lamp_line(const char* key, const CalibratedDelay& delay) {
  return fmt::format("{} = {:.3f}    # +- {:.3f} (mean of {} flashes; {:.2f} from flash to flash)", key,
                     delay.mean, delay.mean_sd, delay.count, delay.sd);
}

}  // namespace

DelayCalibration delay_calibration(const shot_t& shot) {
  DelayCalibration calibration;
  calibration.lamp_a_us = lamp_delay_us(shot, strobe_msgs::coded_flash_t::LAMP_A, &flash_t::observed_a_ns);
  calibration.lamp_b_us = lamp_delay_us(shot, strobe_msgs::coded_flash_t::LAMP_B, &flash_t::observed_b_ns);
  if (shot.shutter_feedback == shot_t::FEEDBACK_SEEN || shot.shutter_feedback == shot_t::FEEDBACK_LATE) {
    calibration.opening_lag_ms = lag_ms(from_ns(shot.shutter_open_ns), from_ns(shot.shutter_on_ns));
    calibration.closing_lag_ms = lag_ms(from_ns(shot.shutter_close_ns), from_ns(shot.shutter_off_ns));
  }
  return calibration;
}

std::vector<std::string> calibration_lines(const DelayCalibration& calibration) {
  std::vector<std::string> lines;
  if (calibration.lamp_a_us || calibration.lamp_b_us) lines.emplace_back("[lamps]");
  if (calibration.lamp_a_us) lines.push_back(lamp_line("delay_a_us", *calibration.lamp_a_us));
  if (calibration.lamp_b_us) lines.push_back(lamp_line("delay_b_us", *calibration.lamp_b_us));
  if (calibration.opening_lag_ms && calibration.closing_lag_ms) {
    const double mean = 0.5 * (*calibration.opening_lag_ms + *calibration.closing_lag_ms);
    lines.emplace_back("[shutter]");
    lines.push_back(fmt::format("lag_ms = {:.2f}    # +- {:.2f} (opened after {:.2f}, closed after {:.2f})",
                                mean,
                                0.5 * std::abs(*calibration.opening_lag_ms - *calibration.closing_lag_ms),
                                *calibration.opening_lag_ms, *calibration.closing_lag_ms));
  }
  return lines;
}

}  // namespace strobe::host
