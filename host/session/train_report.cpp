#include "host/session/train_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/reduction/series.hpp"
#include "host/assembly/flash_times.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::flash_t;
constexpr std::int64_t kNoTime = flash_t::NO_TIME;

class Spread {
 public:
  void add_ns(std::int64_t value_ns) {
    const double value_us = static_cast<double>(value_ns) * 1e-3;
    series_.add(value_us);
    largest_ = std::max(largest_, std::abs(value_us));
  }
  MeanSdMax result() const {
    return {static_cast<int>(series_.count()), series_.mean(), series_.population_sd(), largest_};
  }

 private:
  reduction::Series series_;
  double largest_ = 0.0;
};

nlohmann::ordered_json to_json(const MeanSdMax& value) {
  if (value.count == 0) return nullptr;
  return {{"n", value.count}, {"mean", value.mean}, {"sd", value.sd}, {"max_abs", value.largest}};
}

std::string words(const MeanSdMax& value) {
  if (value.count == 0) return "none";
  return fmt::format("{:.2f} ± {:.2f} us, at most {:.2f}", value.mean, value.sd, value.largest);
}

}  // namespace

TrainReport train_report(const strobe_msgs::shot_t& shot) {
  TrainReport report;
  report.planned = static_cast<int>(shot.flashes.size());
  if (shot.sensor_a_fitted) report.seen_by_a = 0;
  if (shot.sensor_b_fitted) report.seen_by_b = 0;
  Spread lateness, delay, skew;
  for (const flash_t& flash : shot.flashes) {
    const bool issued = flash.issue_end_ns != kNoTime;
    const bool a = flash.observed_a_ns != kNoTime;
    const bool b = flash.observed_b_ns != kNoTime;
    report.issued += issued;
    if (issued) lateness.add_ns(flash.issue_end_ns - flash.commanded_ns);
    if (report.seen_by_a && a) ++*report.seen_by_a;
    if (report.seen_by_b && b) ++*report.seen_by_b;
    if (a && b) skew.add_ns(flash.observed_a_ns - flash.observed_b_ns);
    if (issued && (a || b)) {
      const std::int64_t first = a ? flash.observed_a_ns : flash.observed_b_ns;
      delay.add_ns((a && b ? first + (flash.observed_b_ns - first) / 2 : first) - flash.issue_end_ns);
    }
  }
  for (const SeenFlash& flash : flash_times(shot).seen) {
    report.late += flash.late;
    report.doubled += flash.doubled;
  }
  report.issue_lateness_us = lateness.result();
  report.lamp_delay_us = delay.result();
  report.skew_us = skew.result();
  return report;
}

std::vector<std::string> describe(const TrainReport& report) {
  const auto seen = [](const std::optional<int>& n) {
    return n ? std::to_string(*n) : std::string("not fitted");
  };
  return {
      fmt::format("flashes planned {}, issued {}, seen by sensor A {}, by sensor B {}, late {}, double {}",
                  report.planned, report.issued, seen(report.seen_by_a), seen(report.seen_by_b), report.late,
                  report.doubled),
      "issue lateness    " + words(report.issue_lateness_us),
      "lamp delay        " + words(report.lamp_delay_us),
      "skew A-B          " + words(report.skew_us),
  };
}

bool sound(const TrainReport& report) {
  const bool seen = report.seen_by_a.value_or(report.planned) == report.planned &&
                    report.seen_by_b.value_or(report.planned) == report.planned;
  return report.issued == report.planned && seen && report.late == 0 && report.doubled == 0;
}

std::string train_report_json(const TrainReport& report, int shot_id) {
  const auto count = [](const std::optional<int>& n) {
    return n ? nlohmann::ordered_json(*n) : nlohmann::ordered_json(nullptr);
  };
  const nlohmann::ordered_json json{{"shot_id", shot_id},
                                    {"dry", true},
                                    {"planned", report.planned},
                                    {"issued", report.issued},
                                    {"seen_by_a", count(report.seen_by_a)},
                                    {"seen_by_b", count(report.seen_by_b)},
                                    {"late", report.late},
                                    {"double", report.doubled},
                                    {"issue_lateness_us", to_json(report.issue_lateness_us)},
                                    {"lamp_delay_us", to_json(report.lamp_delay_us)},
                                    {"skew_us", to_json(report.skew_us)}};
  return json.dump();
}

}  // namespace strobe::host
