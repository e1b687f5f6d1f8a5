// A DISARM that somebody has asked for: sent again and again until the firmware says that it has obeyed one of them. Only
// that event tells: a rig that is stopped may have been so before, by a stop that somebody is about to reset. Decides only;
// the host loop sends. Single-threaded; no I/O.
#pragma once

#include <optional>
#include <string>
#include <strobe_msgs/event_t.hpp>

#include "common/units/time.hpp"

namespace strobe::host {

class DisarmRequest {
 public:
  static constexpr Duration kRepeat = milliseconds{100};
  /// Not confirmed for so long it is told as a danger.
  static constexpr Duration kConfirmWithin = milliseconds{500};

  /// host_id: this host's.
  explicit DisarmRequest(std::int64_t host_id) : host_id_(host_id) {}

  /// What was sent before it confirms nothing any more.
  void begin(HostTime now);
  /// Whether a DISARM is to be sent now; counts as sent.
  bool due(HostTime now);
  void on_sent(std::int64_t command_id);
  /// Returns true if this is the confirmation: of a firmware of boot_id, the one that is addressed.
  bool on_event(const strobe_msgs::event_t& event, std::int64_t boot_id);

  /// Asked for, and not confirmed.
  bool open() const { return asked_.has_value(); }
  /// For a person: empty as long as a confirmation is not overdue.
  std::string not_confirmed(HostTime now) const;

 private:
  std::int64_t host_id_;
  std::optional<HostTime> asked_;
  HostTime sent_;
  std::int64_t first_command_ = 0;  ///< 0: none was sent
};

}  // namespace strobe::host
