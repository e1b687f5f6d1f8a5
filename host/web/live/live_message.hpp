// What the host's loop tells the page, and what the page asks of it. Plain values.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <strobe_msgs/status_t.hpp>
#include <variant>

#include "common/authentication/unverified.hpp"
#include "host/clock/device_clock.hpp"
#include "host/session/shot.hpp"

namespace strobe::web {

struct LiveStatus {
  std::shared_ptr<const strobe_msgs::status_t> status;  ///< newest; null: no firmware was ever heard
  bool silent = true;                                   ///< it has not been heard for a while
  double age_s = 0.0;                                   ///< of the newest status
  std::string danger;    ///< of outputs that may be active; empty: none is known of
  std::string missing;   ///< why nothing can be fired; empty: it can
  std::string activity;  ///< what is under way; empty: nothing to say
  std::string armed_by;  ///< who holds the arming, if that is known
  host::ClockState clock;
  int shots = 0;              ///< whose results have come
  int counted = 0;            ///< of them, and of those before that the series goes on with
  std::optional<int> wanted;  ///< shots that are to count
  std::int64_t events_missing = 0;
  bool verified = true;
  authentication::UnverifiedCounts unverified;
  std::size_t photographs_pending = 0;
  bool can_stop = false, can_disarm = false;
};

struct LiveShot {
  host::Shot result;
  std::string utc;  ///< when the result came
};

struct LiveNotification {
  std::string utc, text;
};

using LiveMessage = std::variant<LiveStatus, LiveShot, LiveNotification>;

struct LiveCommand {
  enum class Kind {
    stop,   ///< finish the shot under way, then end the series
    disarm  ///< now; a shot under way is aborted
  };
  Kind kind = Kind::stop;
  std::string from;  ///< the viewer's address
};

}  // namespace strobe::web
