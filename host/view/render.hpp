// What the screen of `strobe fire` and `strobe live` shows. Plain values; single-threaded.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/authentication/unverified.hpp"
#include "common/data/thesis_data.hpp"
#include "host/clock/device_clock.hpp"
#include "host/series/series.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

struct ViewModel {
  std::string title;                            ///< command, rig, session
  std::string activity;                         ///< what is under way; empty: nothing to say
  std::string blocking_reason;                  ///< why nothing can be fired; empty: nothing is known of
  std::optional<strobe_msgs::status_t> status;  ///< newest; absent: no firmware was ever heard
  std::string danger;                           ///< of outputs that may be active; empty: none is known of
  bool silent = false;                          ///< the firmware has not been heard for a while
  double status_age_s = 0.0;
  ClockState clock;
  std::int64_t events_missing = 0;              ///< that did not arrive here
  bool verified = true;                         ///< false: whatever comes is shown, the lab's or not
  authentication::UnverifiedCounts unverified;  ///< packets that were not acted on
  int shots = 0;                                ///< whose results have come
  std::optional<Shot> last;
  Series series;                            ///< of the last shots of one condition (host/series/select.hpp)
  Shot series_condition;                    ///< notes and rig of those that count
  bool all = false;                         ///< experts' numbers as well
  std::optional<thesis::Condition> thesis;  ///< the thesis's series of the same spin and angle
  std::vector<std::string> notifications;   ///< newest last; the last 50 are kept

  void add(const Shot& result);
  void add_notification(const std::string& text);
  /// Brings up to date what is read from the session. Returns a line for a person if the clocks have become
  /// implausible.
  std::optional<std::string> update(Session& session, HostTime now);
};

/// The owner's words, else the firmware's; empty: it can be fired.
std::string why_nothing_can_be_fired(const ViewModel& model);

// The screen of `strobe fire` and `strobe live` as lines of text: a pure function of what is to be shown.
// No I/O, no escape codes; thread-safe.

/// At most width columns a line; narrow terminals lose the series' columns before the shot's numbers.
std::vector<std::string> render(const ViewModel& model, std::size_t width);

/// Parts of it, for plain output.
std::vector<std::string> render_firmware(const ViewModel& model, std::size_t width);
/// The essential numbers (series_view.hpp) with their total standard uncertainty. `all`: every number, what
/// its uncertainty is made of, and which flashes show the ball.
std::vector<std::string> render_shot(const Shot& shot_result, std::size_t width, bool all = false);
/// render_summary() of the series.
std::vector<std::string> render_series(const Series& series,
                                       const std::optional<thesis::Condition>& condition, std::size_t width,
                                       bool all = false);

}  // namespace strobe::host
