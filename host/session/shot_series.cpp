#include "host/session/shot_series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace strobe::host {
namespace {

using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr Duration kSendAgain = milliseconds{300};
// After a token is gone without a sign of the shot: its events and status may still be on their way.
constexpr Duration kSignOfShot = milliseconds{1500};
constexpr int kMaxRefusals = 3;
/// From the command to the first that is heard of the firmware that it is for.
constexpr Duration kBeginWithin = std::chrono::seconds{10};
/// The firmware's word for it (firmware/core/interlock.cpp).
constexpr std::string_view kDisarmedByCommand = "disarmed by command";
constexpr std::string_view kSuspended = "the rig's computer was suspended";

/// Of a key or an e-stop that a person has to move first; null: neither.
const char* switch_in_the_way(const status_t& status) {
  if (status.estop_active) return "the e-stop is pressed, or its wire is broken";
  return status.key_active ? nullptr : "the key is off, or its wire is broken";
}

/// Why the rig may not go on with what began before; empty: it may.
std::string stop_of(const status_t& status) {
  if (const char* const words = switch_in_the_way(status)) return words;
  const bool stopped = status.state == status_t::STOPPED, fault = status.state == status_t::FAULT;
  if (!stopped && !fault) return "";
  return !status.message.empty() ? status.message : stopped ? "the rig was stopped" : "the rig has a fault";
}

std::string rejection_in_full(const Shot& shot_result) {
  const std::string& flag = *shot_result.rejected;
  return shot_result.problem.empty() ? flag : flag + ": " + shot_result.problem;
}

}  // namespace

std::string ShotSeries::why_blocked(const status_t& status) {
  if (!status.message.empty()) return status.message;
  if (status.state == status_t::FAULT) return "the firmware has latched a fault";
  if (!status.journal_ok) return "the firmware's journal cannot be written";
  if (status.arm_host_id != 0 && status.arm_host_id != factory_.host_id()) return who_armed(status);
  if (status.state == status_t::FIRING) return "the rig is firing a shot already";
  return obstacle();
}

/// In words that stay the same as long as the arming lasts.
std::string ShotSeries::who_armed(const status_t& status) {
  if (!own_arming_)
    return "another host " + (arming_host_.empty() ? "" : "(" + arming_host_ + ") ") + "has armed the rig";
  if (!left_of_arming_ || left_of_arming_->first != status.arm_token) {
    const double left_s = to_seconds(from_ns(status.arm_expires_ns) - from_ns(status.mono_ns));
    left_of_arming_ = {status.arm_token, fmt::format("{:.0f} s", std::max(0.0, std::ceil(left_s)))};
  }
  return "an earlier run of yours still holds the arming for " + left_of_arming_->second;
}

void ShotSeries::on_arming_of(std::string host_name, bool own) {
  arming_host_ = std::move(host_name);
  own_arming_ = own || (!arming_host_.empty() && arming_host_ == factory_.host_name());
}

void ShotSeries::on_danger(const std::string& danger) {
  if (!danger.empty() && state_ != State::finished) give_up(danger);
}

void ShotSeries::enter(State state, HostTime now) {
  if (state == State::waiting && !ending_.empty()) return give_up(ending_);
  state_ = state;
  entered_ = now;
  sent_ = now;
}

bool ShotSeries::ours(const status_t& status) const {
  return status.arm_host_id == factory_.host_id() && status.arm_token != 0;
}

double ShotSeries::longest_shot_s() const {
  return to_seconds(settings_.plan.exposure) + settings_.photograph_timeout_s + 15.0;
}

void ShotSeries::give_up(const std::string& why) {
  notifications_.push_back("the series ends: " + why);
  blocking_reason_ = why;
  state_ = State::finished;
}

void ShotSeries::end_after_shot(const std::string& why) {
  if (state_ == State::finished || !ending_.empty()) return;
  ending_ = why;
  if (shot_under_way()) return;
  disarm_ = state_ == State::arming;
  give_up(why);
}

/// What a person's act has to do with: nothing begins that a switch is in the way of, and a stop from before
/// is reset.
void ShotSeries::begin(const status_t& status, HostTime now) {
  if (const char* const words = switch_in_the_way(status))
    return give_up(fmt::format("{}: {}, then give the command again", words,
                               status.estop_active ? "release it" : "turn it on"));
  // An e-stop may have been pressed and released before the firmware that is heard now was there to see it.
  if (now - began_ > kBeginWithin)
    return give_up(fmt::format("the firmware was heard only {:.0f} s after the command: give it again",
                               to_seconds(now - began_)));
  if (status.state == status_t::STOPPED) {
    blocking_reason_ = "the rig was stopped: resetting";
    if (now - sent_ < kSendAgain) return;
    commands_.push_back(factory_.reset(status.boot_id));
    return sent(status, now);
  }
  if (status.state == status_t::FAULT) return;  // until it is cleared
  begun_boot_ = status.boot_id;
  begun_after_ = status.last_sequence;
}

void ShotSeries::check_stop(const status_t& status) {
  if (begun_boot_ == 0) return;
  if (status.boot_id != begun_boot_) {
    const bool follows =
        std::ranges::any_of(status.earlier, [this](const auto& boot) { return boot.boot_id == begun_boot_; });
    if (admitted_ || follows) return end_after_shot("the firmware was started anew");
    return begin(status, now_);  // what was heard before was a log that is played back
  }
  if (const std::string words = stop_of(status); !words.empty()) end_after_shot(words);
}

void ShotSeries::step(const std::optional<status_t>& status, HostTime now) {
  now_ = now;
  if (state_ == State::waiting && succeeded()) state_ = State::finished;
  if (state_ == State::finished) return;
  if (!blocked_since_) blocked_since_ = began_ = now;
  if (status && begun_boot_ == 0) begin(*status, now);
  if (status) check_stop(*status);
  if (state_ == State::finished) return;
  if (!status) {
    blocking_reason_ = "no firmware heard; is strobed running, with the same rig name and LCM URL?";
  } else {
    switch (state_) {
      case State::waiting:
        if (begun_boot_ == 0 && status->state == status_t::STOPPED) break;
        wait_for_readiness(*status, now);
        break;
      case State::arming:
        arm(*status, now);
        break;
      case State::firing:
        fire(*status, now);
        break;
      case State::shooting:
        shoot(*status, now);
        break;
      case State::finished:
        break;
    }
  }
  if (blocking_reason_.empty()) blocked_since_ = now;
  if (state_ != State::finished && to_seconds(now - *blocked_since_) > settings_.blocked_timeout_s) {
    give_up(fmt::format("{} (waited {} s)", blocking_reason_, settings_.blocked_timeout_s));
  }
}

void ShotSeries::wait_for_readiness(const status_t& status, HostTime now) {
  // FIRE seemed refused or lost, and was not: another shot now would be one too many.
  if (fired_ && status.boot_id == boot_id_ && status.last_shot_id > shots_before_)
    return enter(State::shooting, now);
  blocking_reason_ = ours(status) ? obstacle() : why_blocked(status);
  if (status.state == status_t::FAULT && settings_.clear_fault && now - sent_ > kSendAgain) {
    commands_.push_back(factory_.clear(status.boot_id));
    sent_ = now;
  }
  if (!blocking_reason_.empty()) return;
  // refused though nothing seemed missing: say so and try at the pace of the retries
  if (!refusal_.empty()) {
    blocking_reason_ = refusal_;
    if (now - entered_ < kSendAgain) return;
    blocking_reason_.clear();
  }
  if (now < quiet_until_) return;
  enter(State::arming, now);
  if (!ours(status)) send_arm(status, now);
}

void ShotSeries::arm(const status_t& status, HostTime now) {
  blocking_reason_ = unanswered_;
  if (ours(status)) {
    // Nothing is fired with the token, which expires by itself: a DISARM would end the series.
    if (!obstacle().empty()) return enter(State::waiting, now);
    refusal_.clear();
    blocking_reason_.clear();
    admitted_ = true;
    boot_id_ = status.boot_id;
    shots_before_ = status.last_shot_id;
    enter(State::firing, now);
    send_fire(status, now);
    return;
  }
  if (!why_blocked(status).empty()) return enter(State::waiting, now);
  if (now - sent_ < kSendAgain) return;
  send_arm(status, now);
}

void ShotSeries::send_arm(const status_t& status, HostTime now) {
  // Where a stop was reset by another host, it was for that one's series only.
  if (!admitted_) commands_.push_back(factory_.reset(status.boot_id));
  commands_.push_back(factory_.arm(status.boot_id));
  sent(status, now);
}

void ShotSeries::send_fire(const status_t& status, HostTime now) {
  assert(ours(status) && ending_.empty());
  commands_.push_back(factory_.fire(status.boot_id, status.arm_token, settings_.plan, settings_.notes));
  fired_ = true;
  sent(status, now);
}

void ShotSeries::sent(const status_t& status, HostTime now) {
  sent_ = now;
  asked_boot_ = status.boot_id;
  asked_after_ = status.last_sequence;
}

void ShotSeries::fire(const status_t& status, HostTime now) {
  const bool same_boot = status.boot_id == boot_id_;
  if (same_boot && (status.state == status_t::FIRING || status.last_shot_id > shots_before_)) {
    return enter(State::shooting, now);
  }
  // The token is for one shot, so a second FIRE with it can never fire a second one.
  if (same_boot && ours(status)) {
    if (now - sent_ < kSendAgain) return;
    // What was sent may have been heard: a DISARM now could abort a good shot.
    if (ending_.empty() && !obstacle().empty()) return;
    if (ending_.empty()) return send_fire(status, now);
    disarm_ = true;  // what was sent got lost, and is not sent again
    return give_up(ending_);
  }
  if (now - sent_ >= kSignOfShot) enter(State::waiting, now);
}

void ShotSeries::shoot(const status_t& status, HostTime now) {
  if (status.boot_id != boot_id_ && to_seconds(now - entered_) > settings_.photograph_timeout_s + 2.0) {
    on_rejected("the firmware was started anew during the shot", shots_before_ + 1);
  } else if (to_seconds(now - entered_) > longest_shot_s()) {
    on_rejected("nothing more was heard of the shot", shots_before_ + 1);
  }
}

void ShotSeries::on_event(const event_t& event) {
  if (state_ == State::firing && event.kind == event_t::SHOT_STARTED && event.boot_id == boot_id_ &&
      event.shot_id > shots_before_) {
    enter(State::shooting, now_);
  }
  // A refusal from before the command is none of it: it was lost and came late, or a log is played back.
  const bool answers = event.boot_id == asked_boot_ && event.sequence > asked_after_;
  on_stop_event(event);
  if (begun_boot_ == 0 && event.kind == event_t::REFUSED && answers && event.detail.starts_with("RESET"))
    return give_up("refused: " + event.detail);
  if (event.kind != event_t::REFUSED || !answers || (state_ != State::arming && state_ != State::firing))
    return;
  refusal_ = "refused: " + event.detail;
  notifications_.push_back(refusal_);
  if (state_ == State::firing && ++refusals_ >= kMaxRefusals) return give_up(refusal_);
  enter(State::waiting, now_);
}

/// A stop of which no status was heard, as it was lost or another person has had it reset.
void ShotSeries::on_stop_event(const event_t& event) {
  if (begun_boot_ == 0 || event.boot_id != begun_boot_ || event.sequence <= begun_after_) return;
  const bool disarmed = event.kind == event_t::DISARMED || event.kind == event_t::SHOT_ABORTED;
  if (disarmed && event.detail.starts_with(kDisarmedByCommand))
    return end_after_shot("another host has disarmed the rig");
  if (disarmed && event.detail == kSuspended) return end_after_shot(event.detail);
  if (event.kind == event_t::KEY) end_after_shot("the key was turned off");
  if (event.kind == event_t::ESTOP) end_after_shot("the e-stop was pressed");
}

void ShotSeries::on_shot_result(const Shot& shot_result) {
  if (shot_result.host_id != factory_.host_id() || state_ == State::finished) return;
  if (state_ != State::shooting && state_ != State::firing) return;
  if (shot_result.boot_id != boot_id_ || shot_result.shot_id <= shots_before_) return;
  refusals_ = 0;
  fired_ = false;
  if (!stamped_ && shot_result.readout.flags.has(reduction::Flag::no_photograph))
    quiet_until_ = now_ + from_seconds(settings_.photograph_timeout_s);
  if (shot_result.rejected) return on_rejected(rejection_in_full(shot_result), shot_result.shot_id);
  ++good_;
  if (good_ >= settings_.shots) {
    state_ = State::finished;
  } else {
    enter(State::waiting, now_);
  }
}

void ShotSeries::on_former_result(const Shot& shot_result) {
  if (settings_.whole_session && !shot_result.rejected && !shot_result.dry) ++good_;
}

void ShotSeries::on_rejected(const std::string& why, std::int64_t shot_id) {
  if (!ending_.empty()) {
    notifications_.push_back(fmt::format("shot {} does not count: {}", shot_id, why));
    return give_up(ending_);
  }
  if (refired_ >= settings_.retries) {
    return give_up(fmt::format("shot {} does not count ({}), and none may be fired again", shot_id, why));
  }
  ++refired_;
  fired_ = false;
  notifications_.push_back(fmt::format("shot {} does not count ({}): firing again, {} of {} times", shot_id,
                                       why, refired_, settings_.retries));
  enter(State::waiting, now_);
}

std::string ShotSeries::activity() const {
  const std::string of =
      fmt::format("shot {} of {}{}", good_ + 1, settings_.at_most ? "at most " : "", settings_.shots);
  switch (state_) {
    case State::waiting:
      return of + (now_ < quiet_until_ ? ": waiting, as a photograph may still come"
                                       : ": waiting until the rig can be armed");
    case State::arming:
      return of + ": arming";
    case State::firing:
      return of + ": armed, firing";
    case State::shooting:
      return of + (settings_.plan.dry ? ": flashing" : ": fired, waiting for the photograph");
    case State::finished:
      return fmt::format("{} of {} shots", good_, settings_.shots);
  }
  return "";
}

}  // namespace strobe::host
