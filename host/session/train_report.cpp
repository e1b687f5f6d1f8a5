#include "host/session/train_report.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/reduction/running_statistics.hpp"
#include "common/units/time.hpp"
#include "host/assembly/flash_times.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;

class Spread {
 public:
  void add(Duration value) {
    const double value_us = to_microseconds(value);
    series_.add(value_us);
    largest_ = std::max(largest_, std::abs(value_us));
  }
  MeanSdMax result() const {
    return {static_cast<int>(series_.count()), series_.mean(), series_.population_sd(), largest_};
  }

 private:
  reduction::RunningStatistics series_;
  double largest_ = 0.0;
};

nlohmann::ordered_json to_json(const MeanSdMax& value) {
  if (value.count == 0) return nullptr;
  return {{"n", value.count}, {"mean", value.mean}, {"sd", value.sd}, {"max_abs", value.largest}};
}

nlohmann::ordered_json to_json(const std::optional<CalibratedDelay>& delay) {
  if (!delay) return nullptr;
  return {{"n", delay->count}, {"mean", delay->mean}, {"sd", delay->sd}, {"mean_sd", delay->mean_sd}};
}

nlohmann::ordered_json to_json(const DelayCalibration& calibration) {
  return {{"lamp_delay_a_us", to_json(calibration.lamp_a_us)},
          {"lamp_delay_b_us", to_json(calibration.lamp_b_us)},
          {"shutter_opening_lag_ms", messages::or_null(calibration.opening_lag_ms)},
          {"shutter_closing_lag_ms", messages::or_null(calibration.closing_lag_ms)}};
}

std::string spread_words(const MeanSdMax& value) {
  if (value.count == 0) return "none";
  return fmt::format("{:.2f} ± {:.2f} us, at most {:.2f} us", value.mean, value.sd, value.largest);
}

}  // namespace

TrainReport train_report(const strobe_msgs::shot_t& shot, const FlashTimes& times) {
  TrainReport report;
  report.planned = static_cast<int>(shot.flashes.size());
  if (shot.sensor_a_fitted) report.seen_by_a = 0;
  if (shot.sensor_b_fitted) report.seen_by_b = 0;
  Spread lateness, delay, skew;
  for (const flash_t& flash : shot.flashes) {
    const MonoTime issued = from_ns(flash.issue_end_ns);
    const MonoTime a = from_ns(flash.observed_a_ns), b = from_ns(flash.observed_b_ns);
    const bool lamp_a = (flash.lamps & strobe_msgs::coded_flash_t::LAMP_A) != 0;
    const bool lamp_b = (flash.lamps & strobe_msgs::coded_flash_t::LAMP_B) != 0;
    report.planned_a += lamp_a;
    report.planned_b += lamp_b;
    report.issued += known(issued);
    if (known(issued)) lateness.add(issued - from_ns(flash.commanded_ns));
    if (report.seen_by_a && known(a) && lamp_a) ++*report.seen_by_a;
    if (report.seen_by_b && known(b) && lamp_b) ++*report.seen_by_b;
    if (known(a) && known(b) && lamp_a && lamp_b) skew.add(a - b);
    if (known(issued) && report.seen_by_a && lamp_a && !known(a))
      report.faults.unseen_by_a.push_back(flash.flash_index);
    if (known(issued) && report.seen_by_b && lamp_b && !known(b))
      report.faults.unseen_by_b.push_back(flash.flash_index);
  }
  for (const ObservedFlash& flash : times.seen) {
    report.late += flash.late;
    report.doubled += flash.doubled;
    if (flash.late) report.faults.late.push_back(flash.index);
    if (flash.doubled) report.faults.doubled.push_back(flash.index);
    const MonoTime issued = from_ns(shot.flashes[static_cast<std::size_t>(flash.index)].issue_end_ns);
    if (times.measured && known(issued)) delay.add(flash.time - issued);
  }
  report.faults.missing = times.missing;
  report.calibration = delay_calibration(shot);
  report.issue_lateness_us = lateness.result();
  report.lamp_delay_us = delay.result();
  report.skew_us = skew.result();
  return report;
}

std::vector<std::string> describe(const TrainReport& report) {
  const auto seen = [](const std::optional<int>& n) {
    return n ? std::to_string(*n) : std::string("not fitted");
  };
  const bool single_lamps = report.planned_a + report.planned_b > 0 &&
                            (report.planned_a != report.planned || report.planned_b != report.planned);
  std::vector<std::string> lines{
      fmt::format(
          "flashes planned {}{}, issued {}, seen by sensor A {}, by sensor B {}, late {}, double {}",
          report.planned,
          single_lamps ? fmt::format(" (lamp A {}, lamp B {})", report.planned_a, report.planned_b) : "",
          report.issued, seen(report.seen_by_a), seen(report.seen_by_b), report.late, report.doubled),
      "issue lateness    " + spread_words(report.issue_lateness_us),
      "lamp delay        " + spread_words(report.lamp_delay_us),
      "skew A-B          " + spread_words(report.skew_us),
  };
  const std::vector<std::string> values = calibration_lines(report.calibration);
  if (!values.empty()) lines.emplace_back("measured, for the rig file:");
  for (const std::string& value : values) lines.push_back("  " + value);
  return lines;
}

bool sound(const TrainReport& report) {
  const bool seen = report.seen_by_a.value_or(report.planned_a) == report.planned_a &&
                    report.seen_by_b.value_or(report.planned_b) == report.planned_b;
  return report.issued == report.planned && seen && report.late == 0 && report.doubled == 0;
}

nlohmann::ordered_json train_report_json(const TrainReport& report, int shot_id) {
  return {{"shot_id", shot_id},
          {"dry", true},
          {"planned", report.planned},
          {"planned_a", report.planned_a},
          {"planned_b", report.planned_b},
          {"issued", report.issued},
          {"seen_by_a", messages::or_null(report.seen_by_a)},
          {"seen_by_b", messages::or_null(report.seen_by_b)},
          {"late", report.late},
          {"double", report.doubled},
          {"issue_lateness_us", to_json(report.issue_lateness_us)},
          {"lamp_delay_us", to_json(report.lamp_delay_us)},
          {"skew_us", to_json(report.skew_us)},
          {"calibration", to_json(report.calibration)}};
}

namespace {

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
  calibration.stated_a_us = shot.lamp_delay_a_us;
  calibration.stated_b_us = shot.lamp_delay_b_us;
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
