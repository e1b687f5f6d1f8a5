#include "host/commission/electrical/shutter_judgement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/commission/core/sample.hpp"
#include "host/session/delay_calibration.hpp"

namespace strobe::commission {
namespace {

using strobe_msgs::shot_t;

/// Of good rigs within the limit: one in a thousand is beyond it on either side.
constexpr double kLagWithinByChance = 0.998;

/// Absent: the lag is as the rig file has it.
std::optional<StepResult> lag_fault(const std::string& id, const char* what, const Sample& lag_ms,
                                    double expected_ms, double tolerance_ms) {
  const double off_ms = lag_ms.mean() - expected_ms;
  if (std::abs(off_ms) <= tolerance_ms + lag_ms.mean_margin(kLagWithinByChance)) return std::nullopt;
  return failed(
      id, off_ms > 0 ? "shutter_late" : "shutter_early",
      fmt::format("the shutter {} {:.2f} ms after its line, the rig file says {:.2f}", what, lag_ms.mean(),
                  expected_ms),
      fmt::format("if the shutter is what it should be, write lag_ms = {:.1f} into [shutter] and start "
                  "strobed anew",
                  lag_ms.mean()));
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
  Sample opening_ms, closing_ms;
  for (const shot_t& shot : shots) {
    const auto found = host::delay_calibration(shot);
    if (found.opening_lag_ms) opening_ms.add(*found.opening_lag_ms);
    if (found.closing_lag_ms) closing_ms.add(*found.closing_lag_ms);
  }
  const double expected_ms = 1e3 * rig.shutter_lag_s.value_or(0.0);
  const double tolerance_ms = rig.commission.shutter_tolerance_ms;
  StepResult result;
  if (auto fault = lag_fault(id, "opens", opening_ms, expected_ms, tolerance_ms)) {
    result = std::move(*fault);
  } else if (auto uneven = lag_fault(id, "closes", closing_ms, expected_ms, tolerance_ms)) {
    result = std::move(*uneven);
  } else {
    result.id = id;
    result.state = StepState::passed;
    result.words = fmt::format(
        "the shutter opens {:.2f} ± {:.2f} ms and closes {:.2f} ± {:.2f} ms after its line "
        "(rig file: {:.1f})",
        opening_ms.mean(), opening_ms.mean_sd(), closing_ms.mean(), closing_ms.mean_sd(), expected_ms);
  }
  result.value = opening_ms.mean();
  result.sd = opening_ms.mean_sd();
  result.unit = "ms";
  result.limit = fmt::format("{:.1f} ± {:.1f} ms", expected_ms, tolerance_ms);
  result.figures = {
      {"opening_lag_ms", opening_ms.mean(), opening_ms.mean_sd(), expected_ms, opening_ms.count()},
      {"closing_lag_ms", closing_ms.mean(), closing_ms.mean_sd(), expected_ms, closing_ms.count()}};
  return result;
}

}  // namespace strobe::commission
