#include "host/commission/electrical/shutter_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/reduction/running_statistics.hpp"
#include "common/reduction/student_t.hpp"
#include "host/session/delay_calibration.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::shot_t;

struct Lag {
  reduction::RunningStatistics values;
  double mean_ms() const { return values.mean(); }
  double mean_sd_ms() const {
    const auto n = static_cast<double>(values.count());
    return n > 1 ? values.population_sd() / std::sqrt(n - 1.0) : 0.0;
  }
  double margin_ms() const {
    const auto n = static_cast<double>(values.count());
    return n > 1 ? reduction::student_t_half_width(0.998, n - 1.0) * mean_sd_ms() : 0.0;
  }
};

/// Absent: the lag is as the rig file has it.
std::optional<StepResult> lag_fault(const std::string& id, const char* what, const Lag& lag,
                                    double expected_ms, double tolerance_ms) {
  const double off_ms = lag.mean_ms() - expected_ms;
  if (std::abs(off_ms) <= tolerance_ms + lag.margin_ms()) return std::nullopt;
  return failed(
      id, off_ms > 0 ? "shutter_late" : "shutter_early",
      fmt::format("the shutter {} {:.2f} ms after its line, the rig file says {:.2f}", what, lag.mean_ms(),
                  expected_ms),
      fmt::format("if the shutter is what it should be, write lag_ms = {:.1f} into [shutter] and start "
                  "strobed anew",
                  lag.mean_ms()));
}

}  // namespace

StepResult judge_shutter(const std::string& id, std::span<const shot_t> shots, const host::RigFile& rig) {
  const auto with = [&](std::int8_t feedback) {
    return std::ranges::count_if(shots, [&](const shot_t& s) { return s.shutter_feedback == feedback; });
  };
  if (with(shot_t::FEEDBACK_NONE) > 0)
    return skipped(id, "the rig file names no contact of the shutter (lines.xsync)",
                   "connect the camera's X-sync contact, or let the photographs show that no flash is lost");
  if (const auto missing = with(shot_t::FEEDBACK_MISSING); missing > 0)
    return failed(
        id, "shutter_stuck",
        fmt::format("in {} of {} shots the shutter's contact did not tell that it opened and closed", missing,
                    shots.size()),
        "look whether the shutter opens: bulb exposure, remote release, opto-coupler, the contact's "
        "wire; a lag longer than late_ms shows as this, too");
  Lag opening, closing;
  for (const shot_t& shot : shots) {
    const auto found = host::delay_calibration(shot);
    if (found.opening_lag_ms) opening.values.add(*found.opening_lag_ms);
    if (found.closing_lag_ms) closing.values.add(*found.closing_lag_ms);
  }
  const double expected_ms = 1e3 * rig.shutter_lag_s.value_or(0.0);
  const double tolerance_ms = rig.commission.shutter_tolerance_ms;
  StepResult result;
  if (auto fault = lag_fault(id, "opens", opening, expected_ms, tolerance_ms)) {
    result = std::move(*fault);
  } else if (auto uneven = lag_fault(id, "closes", closing, expected_ms, tolerance_ms)) {
    result = std::move(*uneven);
  } else {
    result.id = id;
    result.state = StepState::passed;
    result.words = fmt::format(
        "the shutter opens {:.2f} ± {:.2f} ms and closes {:.2f} ± {:.2f} ms after its line "
        "(rig file: {:.1f})",
        opening.mean_ms(), opening.mean_sd_ms(), closing.mean_ms(), closing.mean_sd_ms(), expected_ms);
  }
  result.value = opening.mean_ms();
  result.sd = opening.mean_sd_ms();
  result.unit = "ms";
  result.limit = fmt::format("{:.1f} ± {:.1f} ms", expected_ms, tolerance_ms);
  result.figures = {{"opening_lag_ms", opening.mean_ms(), opening.mean_sd_ms(), expected_ms,
                     static_cast<int>(opening.values.count())},
                    {"closing_lag_ms", closing.mean_ms(), closing.mean_sd_ms(), expected_ms,
                     static_cast<int>(closing.values.count())}};
  return result;
}

}  // namespace strobe::commission
