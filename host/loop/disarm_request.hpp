// A DISARM that somebody has asked for: sent again and again until the firmware is heard to be stopped, which a state says
// that no later command undoes without a person's act (status_t::STOPPED). Decides only; the host loop sends.
// Single-threaded; no I/O.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/status_t.hpp>

#include "common/units/time.hpp"

namespace strobe::host {

class DisarmRequest {
 public:
  static constexpr Duration kRepeat = milliseconds{100};
  /// Not confirmed for so long it is told as a danger.
  static constexpr Duration kConfirmWithin = milliseconds{500};

  /// boot_id, boot_time_ns: of the firmware that is addressed, and its CLOCK_BOOTTIME now or a little earlier; 0: none was
  /// ever heard.
  void begin(HostTime now, std::int64_t boot_id, std::int64_t boot_time_ns);
  /// Whether a DISARM is to be sent now; counts as sent.
  bool due(HostTime now);
  /// Returns true if this status is the confirmation.
  bool on_status(const strobe_msgs::status_t& status);

  /// Asked for, and not confirmed.
  bool open() const { return asked_.has_value(); }
  /// For a person: empty as long as a confirmation is not overdue.
  std::string not_confirmed(HostTime now) const;

 private:
  std::optional<HostTime> asked_;
  HostTime sent_;
  std::int64_t boot_id_ = 0, boot_time_ns_ = 0;
};

}  // namespace strobe::host
