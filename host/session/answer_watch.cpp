#include "host/session/answer_watch.hpp"

#include <fmt/format.h>

namespace strobe::host {
namespace {

using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr int kHeartbeats = 3;  // it goes on while nothing is answered

bool moves_by_itself(std::int8_t kind) {
  switch (kind) {
    case event_t::KEY:
    case event_t::ESTOP:
    case event_t::GATE:
    case event_t::SENSOR:
    case event_t::XSYNC:
    case event_t::FLASH:
    case event_t::SHUTTER:
    case event_t::TRIGGER:
    case event_t::FAULT:
    case event_t::REPAIRED:
    case event_t::STARTED:
    case event_t::STOPPED:
      return true;
    default:
      return false;
  }
}

/// A DISARM of what is disarmed, and events of another boot, which may be lost, have no answer that is certain.
bool must_be_answered(const command_t& command, const status_t& status) {
  if (command.boot_id != status.boot_id) return false;
  if (command.kind == command_t::DISARM) return status.arm_token != 0 || status.state == status_t::FIRING;
  if (command.kind == command_t::RESEND)
    return command.resend_boot_id == command.boot_id && command.resend_last <= status.last_sequence &&
           status.journal_ok != 0;
  return true;
}

}  // namespace

void AnswerWatch::on_sent(const command_t& command, const std::optional<status_t>& status, HostTime now) {
  if (!status || !must_be_answered(command, *status)) return;
  if (boot_id_ != status->boot_id) asked_ = 0;
  if (asked_++ == 0) {
    boot_id_ = status->boot_id;
    since_ = now;
    heartbeats_ = 0;
    forged_ = forged_before_ = status->rejected_forged;
  }
  newest_ = Question{command.kind, command.host_id, status->last_sequence, command.resend_first,
                     command.resend_last};
}

bool AnswerWatch::answered_by(const status_t& status) const {
  if (newest_->kind == command_t::ARM) return status.arm_host_id == newest_->host_id;
  if (newest_->kind == command_t::DISARM) return status.arm_token == 0 && status.state != status_t::FIRING;
  return newest_->kind == command_t::FIRE && status.state == status_t::FIRING;
}

void AnswerWatch::on_status(const status_t& status) {
  if (asked_ == 0 || status.boot_id != boot_id_) return;
  ++heartbeats_;
  forged_ = status.rejected_forged;
  if (answered_by(status)) asked_ = 0;
}

/// What comes of a command, or an event that was asked for.
void AnswerWatch::on_event(const event_t& event) {
  if (asked_ == 0 || event.boot_id != boot_id_) return;
  const bool again = newest_->kind == command_t::RESEND && event.sequence >= newest_->first &&
                     event.sequence <= newest_->last;
  const bool obeyed = event.sequence > newest_->after && !moves_by_itself(event.kind);
  if (again || obeyed) asked_ = 0;
}

std::string AnswerWatch::problem(HostTime now) const {
  if (asked_ < kQuestions || heartbeats_ < kHeartbeats || now - since_ < kLongest) return "";
  std::string words =
      "the rig is heard but does not answer, so no DISARM reaches it either: use the e-stop; look at the "
      "rig's "
      "network interface and at firewalls for multicast to it";
  if (forged_ > forged_before_) words += "; it counts commands sealed with another key (see strobe key)";
  return words;
}

}  // namespace strobe::host
