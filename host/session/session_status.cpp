// What the session makes of the firmware's status messages.
#include <fmt/format.h>

#include <algorithm>

#include "common/messages/danger.hpp"
#include "host/session/session.hpp"

namespace strobe::host {

using strobe_msgs::status_t;

void Session::on_status(const strobe_msgs::status_t& status, HostTime now, const std::string& sender) {
  const bool known = boots_.knows(status.boot_id);
  boots_.on_status(status, sender, now);
  if (outdated(status, now)) return;
  // Of two that are heard in turn none is started anew.
  const bool in_turn = known && now - status_heard_ <= kSilent;
  if (status_ && status_->boot_id != status.boot_id && !in_turn) {
    notify(fmt::format("the firmware was started anew (boot {:x})", status.boot_id));
  }
  const DeviceReading device{from_ns(status.mono_ns), from_ns<WallTime>(status.wall_ns),
                             Duration{status.boot_time_ns}};
  heard_.on_heartbeat(status.boot_id, device.mono);
  clock_.on_heartbeat(status.boot_id, device, now);
  report_clock();
  report_danger(status, now);
  report_arming(status);
  status_ = status;
  status_heard_ = now;
  if (host_id_ != 0 && status.arm_host_id == host_id_) answered_boot_ = status.boot_id;
  ledger_.status(status.boot_id, status.last_sequence, now);
  std::vector<EndedBoot> earlier;
  for (const auto& boot : status.earlier) earlier.push_back({boot.boot_id, boot.last_sequence});
  ledger_.earlier(earlier, now);
  finish_interrupted_shots();
  expire(now);
}

void Session::report_danger(const status_t& status, HostTime now) {
  if (!messages::tells_danger(status.message)) {
    if (!danger_.empty()) notify("the outputs are inactive again; the firmware was heard to say so");
    return danger_.clear();
  }
  if (danger_ == status.message) return;
  danger_ = status.message;
  danger_told_ = now;
  notify(danger_);
}

void Session::report_arming(const status_t& status) {
  const std::int64_t host = status.arm_host_id;
  if (host == 0 || host == arming_told_ || host == host_id_) return;
  const std::string name = host_name(host);
  if (name.empty()) return;
  arming_told_ = host;
  notify("the rig was armed by " + name);
}

std::string Session::host_name(std::int64_t host_id) const {
  const auto* name = host_names_.find(host_id);
  return name ? *name : "";
}

void Session::on_local_clocks(const HostReading& reading) {
  clock_.on_local(reading);
  report_clock();
}

void Session::report_clock() {
  for (std::string& text : clock_.take_notifications()) notify(std::move(text));
}

std::optional<strobe_msgs::status_t> Session::live_status(HostTime now) const {
  return status_ && now - status_heard_ <= kSilent ? status_ : std::nullopt;
}

bool Session::ran_earlier(std::int64_t boot_id) const {
  return status_ && std::ranges::any_of(status_->earlier,
                                        [boot_id](const auto& boot) { return boot.boot_id == boot_id; });
}

/// Overtaken on the way, or of a log that is played back, whose seals are good. Of two boots the later one lists
/// the other; where their session folders differ, another is believed only when the one heard has fallen silent.
/// A firing host believes any until one has answered it, which no log can, and that one then for a cut's time, as
/// a boot's end is its shots' end.
bool Session::outdated(const strobe_msgs::status_t& status, HostTime now) const {
  if (!status_) return false;
  if (status.boot_id == status_->boot_id) return status.mono_ns < status_->mono_ns;
  if (ran_earlier(status.boot_id)) return true;
  const bool follows = std::ranges::any_of(
      status.earlier, [this](const auto& boot) { return boot.boot_id == status_->boot_id; });
  if (follows) return false;
  if (host_id_ == 0) return now - status_heard_ <= kSilent;
  return status_->boot_id == answered_boot_ && now - status_heard_ <= kCutOff;
}

}  // namespace strobe::host
