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
  std::optional<ShotResult> last;
  Series series;                            ///< of the shots, one rig's
  bool all = false;                         ///< experts' numbers as well
  std::optional<thesis::Condition> thesis;  ///< the thesis's series of the same spin and angle
  std::vector<std::string> notifications;   ///< newest last; the last 50 are kept

  void add(const ShotResult& result);
  void add_notification(const std::string& text);
  /// Brings up to date what is read from the session. Returns a line for a person if the clocks have become
  /// implausible.
  std::optional<std::string> update(Session& session, HostTime now);
};

/// All shots of a rig have its calibration; its ball is told apart by its name.
SeriesShot series_shot_of(const ShotResult& result);

/// The owner's words, else the firmware's; empty: it can be fired.
std::string why_nothing_can_be_fired(const ViewModel& model);

}  // namespace strobe::host
