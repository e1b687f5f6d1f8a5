#include "host/session/delay_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/reduction/running_statistics.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;
using strobe_msgs::shot_t;

bool issued(const flash_t& flash) {
  return flash.issue_start_ns != flash_t::NO_TIME && flash.issue_end_ns != flash_t::NO_TIME;
}

/// Of a call that was interrupted nobody knows when the line changed: twice the shortest, and a microsecond.
std::int64_t longest_call_ns(const shot_t& shot) {
  constexpr std::int64_t kMargin_ns = 1000;
  std::optional<std::int64_t> shortest;
  for (const flash_t& flash : shot.flashes) {
    if (!issued(flash)) continue;
    const std::int64_t call = flash.issue_end_ns - flash.issue_start_ns;
    shortest = std::min(shortest.value_or(call), call);
  }
  return 2 * shortest.value_or(0) + kMargin_ns;
}

std::optional<CalibratedDelay> lamp_delay_us(const shot_t& shot, int lamp, std::int64_t flash_t::*observed) {
  reduction::RunningStatistics series;
  const std::int64_t longest_ns = longest_call_ns(shot);
  for (const flash_t& flash : shot.flashes) {
    if ((flash.lamps & lamp) == 0 || !issued(flash) || flash.*observed == flash_t::NO_TIME) continue;
    if (flash.extra_edges > 0 || flash.issue_end_ns - flash.issue_start_ns > longest_ns) continue;
    series.add(static_cast<double>(flash.*observed - flash.issue_end_ns) * 1e-3);
  }
  if (series.count() < 2) return std::nullopt;
  const auto n = static_cast<double>(series.count());
  const double sd = series.population_sd() * std::sqrt(n / (n - 1.0));
  return CalibratedDelay{static_cast<int>(series.count()), series.mean(), sd, sd / std::sqrt(n)};
}

std::optional<double> lag_ms(std::int64_t seen_ns, std::int64_t line_ns) {
  if (seen_ns == shot_t::NO_TIME || line_ns == shot_t::NO_TIME) return std::nullopt;
  return static_cast<double>(seen_ns - line_ns) * 1e-6;
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
  const bool told =
      shot.shutter_feedback == shot_t::FEEDBACK_SEEN || shot.shutter_feedback == shot_t::FEEDBACK_LATE;
  if (told) {
    calibration.opening_lag_ms = lag_ms(shot.shutter_open_ns, shot.shutter_on_ns);
    calibration.closing_lag_ms = lag_ms(shot.shutter_close_ns, shot.shutter_off_ns);
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
