#include "host/session/shot_series.hpp"

#include <fmt/format.h>

namespace strobe::host {
namespace {

using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr std::int64_t kSendAgain_ns = 300'000'000;
// After a token is gone without a sign of the shot: its events and status may still be on their way.
constexpr std::int64_t kSignOfShot_ns = 1'500'000'000;
constexpr int kMaxRefusals = 3;

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

std::string blocking_reason_of(const status_t& status, std::int64_t host_id) {
  if (!status.message.empty()) return status.message;
  if (status.state == status_t::FAULT) return "the firmware has latched a fault";
  if (status.estop_active) return "the e-stop is pressed";
  if (!status.key_active) return "the key is off";
  if (!status.journal_ok) return "the firmware's journal cannot be written";
  if (status.arm_host_id != 0 && status.arm_host_id != host_id) return "another host has armed the rig";
  if (status.state == status_t::FIRING) return "the rig is firing a shot already";
  return "";
}

}  // namespace

void ShotSeries::enter(State state, std::int64_t now_ns) {
  state_ = state;
  entered_ns_ = now_ns;
  sent_ns_ = now_ns;
}

bool ShotSeries::ours(const status_t& status) const {
  return status.arm_host_id == factory_.host_id() && status.arm_token != 0;
}

double ShotSeries::longest_shot_s() const {
  return settings_.plan.shutter_open_ms * 1e-3 + settings_.photograph_timeout_s + 15.0;
}

void ShotSeries::give_up(const std::string& why) {
  notifications_.push_back("giving up: " + why);
  blocking_reason_ = why;
  state_ = State::finished;
}

void ShotSeries::step(const std::optional<status_t>& status, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (state_ == State::finished) return;
  if (!blocked_since_ns_) blocked_since_ns_ = now_ns;
  if (!status) {
    blocking_reason_ = "no firmware heard; is strobed running, with the same rig name and LCM URL?";
  } else {
    switch (state_) {
      case State::waiting:
        wait_for_readiness(*status, now_ns);
        break;
      case State::arming:
        arm(*status, now_ns);
        break;
      case State::firing:
        fire(*status, now_ns);
        break;
      case State::shooting:
        shoot(*status, now_ns);
        break;
      case State::finished:
        break;
    }
  }
  if (blocking_reason_.empty()) blocked_since_ns_ = now_ns;
  if (state_ != State::finished && seconds(now_ns - *blocked_since_ns_) > settings_.blocked_timeout_s) {
    give_up(fmt::format("{} (waited {} s)", blocking_reason_, settings_.blocked_timeout_s));
  }
}

void ShotSeries::wait_for_readiness(const status_t& status, std::int64_t now_ns) {
  blocking_reason_ = ours(status) ? "" : blocking_reason_of(status, factory_.host_id());
  if (status.state == status_t::FAULT && settings_.clear_fault && now_ns - sent_ns_ > kSendAgain_ns) {
    commands_.push_back(factory_.clear(status.boot_id));
    sent_ns_ = now_ns;
  }
  if (!blocking_reason_.empty()) return;
  if (!refusal_
           .empty()) {  // refused though nothing seemed missing: say so and try at the pace of the retries
    blocking_reason_ = refusal_;
    if (now_ns - entered_ns_ < kSendAgain_ns) return;
    blocking_reason_.clear();
  }
  enter(State::arming, now_ns);
  if (!ours(status)) commands_.push_back(factory_.arm(status.boot_id));
}

void ShotSeries::arm(const status_t& status, std::int64_t now_ns) {
  if (ours(status)) {
    refusal_.clear();
    blocking_reason_.clear();
    boot_id_ = status.boot_id;
    shots_before_ = status.last_shot_id;
    enter(State::firing, now_ns);
    send_fire(status, now_ns);
    return;
  }
  if (!blocking_reason_of(status, factory_.host_id()).empty()) return enter(State::waiting, now_ns);
  if (now_ns - sent_ns_ < kSendAgain_ns) return;
  commands_.push_back(factory_.arm(status.boot_id));
  sent_ns_ = now_ns;
}

void ShotSeries::send_fire(const status_t& status, std::int64_t now_ns) {
  commands_.push_back(
      factory_.fire(status.boot_id, status.arm_token, settings_.plan, settings_.dry, settings_.notes));
  sent_ns_ = now_ns;
}

void ShotSeries::fire(const status_t& status, std::int64_t now_ns) {
  const bool same_boot = status.boot_id == boot_id_;
  if (same_boot && (status.state == status_t::FIRING || status.last_shot_id > shots_before_)) {
    return enter(State::shooting, now_ns);
  }
  // The token is for one shot, so a second FIRE with it can never fire a second one.
  if (same_boot && ours(status)) {
    if (now_ns - sent_ns_ >= kSendAgain_ns) send_fire(status, now_ns);
    return;
  }
  if (now_ns - sent_ns_ >= kSignOfShot_ns) enter(State::waiting, now_ns);
}

void ShotSeries::shoot(const status_t& status, std::int64_t now_ns) {
  if (status.boot_id != boot_id_ && seconds(now_ns - entered_ns_) > settings_.photograph_timeout_s + 2.0) {
    on_rejected("the firmware was started anew during the shot", shots_before_ + 1);
  } else if (seconds(now_ns - entered_ns_) > longest_shot_s()) {
    on_rejected("nothing more was heard of the shot", shots_before_ + 1);
  }
}

void ShotSeries::on_event(const event_t& event) {
  if (state_ == State::firing && event.kind == event_t::SHOT_STARTED && event.boot_id == boot_id_ &&
      event.shot_id > shots_before_) {
    enter(State::shooting, now_ns_);
  }
  if (event.kind != event_t::REFUSED || (state_ != State::arming && state_ != State::firing)) return;
  refusal_ = "refused: " + event.detail;
  notifications_.push_back(refusal_);
  if (state_ == State::firing && ++refusals_ >= kMaxRefusals) return give_up(refusal_);
  enter(State::waiting, now_ns_);
}

void ShotSeries::on_shot_result(const ShotResult& shot_result) {
  if (shot_result.host_id != factory_.host_id() || state_ == State::finished) return;
  if (state_ != State::shooting && state_ != State::firing) return;
  if (shot_result.boot_id != boot_id_ || shot_result.shot_id <= shots_before_) return;
  refusals_ = 0;
  if (shot_result.rejected) return on_rejected(*shot_result.rejected, shot_result.shot_id);
  ++good_;
  if (good_ >= settings_.shots) {
    state_ = State::finished;
  } else {
    enter(State::waiting, now_ns_);
  }
}

void ShotSeries::on_rejected(const std::string& why, std::int64_t shot_id) {
  if (refired_ >= settings_.retries) {
    return give_up(fmt::format("shot {} is rejected ({}) and no retries are left", shot_id, why));
  }
  ++refired_;
  notifications_.push_back(fmt::format("shot {} is rejected ({}): firing again, retry {} of {}", shot_id, why,
                                       refired_, settings_.retries));
  enter(State::waiting, now_ns_);
}

void ShotSeries::stop(const std::optional<status_t>& status) {
  if (status &&
      (ours(*status) || state_ == State::arming || state_ == State::firing || state_ == State::shooting)) {
    commands_.push_back(factory_.disarm(status->boot_id));
  }
  state_ = State::finished;
}

std::string ShotSeries::activity() const {
  const std::string of = fmt::format("shot {} of {}", good_ + 1, settings_.shots);
  switch (state_) {
    case State::waiting:
      return of + ": waiting until the rig can be armed";
    case State::arming:
      return of + ": arming";
    case State::firing:
      return of + ": armed, firing";
    case State::shooting:
      return of + (settings_.dry ? ": flashing" : ": fired, waiting for the photograph");
    case State::finished:
      return fmt::format("{} of {} shots", good_, settings_.shots);
  }
  return "";
}

}  // namespace strobe::host
