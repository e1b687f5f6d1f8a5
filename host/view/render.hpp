// The screen of `strobe fire` and `strobe live` as lines of text: a pure function of what is to be shown.
// No I/O, no escape codes; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "host/clock/device_clock.hpp"
#include "host/session/series_statistics.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

struct Model {
  std::string title;                            ///< command, rig, session
  std::string activity;                         ///< what is under way; empty: nothing to say
  std::string blocking_reason;                  ///< what is missing; empty: nothing
  std::optional<strobe_msgs::status_t> status;  ///< newest; absent: no firmware was ever heard
  double status_age_s = 0.0;
  ClockState clock;
  std::int64_t events_missing = 0;  ///< on the way to this host
  std::optional<ShotResult> last;
  SeriesStatistics series;
  std::optional<thesis::Condition> thesis;  ///< the thesis's series of the same spin and angle
  std::vector<std::string> notifications;   ///< newest last
};

/// At most width columns a line; narrow terminals lose the series' columns before the shot's numbers.
std::vector<std::string> render(const Model& model, std::size_t width);

/// Parts of it, for plain output.
std::vector<std::string> render_firmware(const Model& model, std::size_t width);
std::vector<std::string> render_shot(const ShotResult& shot_result, std::size_t width);
/// Mean, sd, coefficient of variation and n of each quantity; beside the thesis's row where there is one.
std::vector<std::string> render_series(const SeriesStatistics& series,
                                       const std::optional<thesis::Condition>& condition, std::size_t width);

}  // namespace strobe::host
