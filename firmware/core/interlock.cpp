#include "firmware/core/interlock.hpp"

#include <algorithm>

namespace strobe::firmware {

namespace {

using Effect = Interlock::Effect;

/// What latched a stop, told as long as it is latched.
const char* stop_words(InterlockEvent event) {
  switch (event) {
    case InterlockEvent::disarm:
      return "disarmed by command";
    case InterlockEvent::key_off:
      return "the key was turned off";
    case InterlockEvent::key_on:
      return "the key was turned on";
    case InterlockEvent::estop_on:
      return "the e-stop was pressed";
    case InterlockEvent::estop_off:
      return "the e-stop was released";
    default:
      return "the rig's computer was suspended";
  }
}

const char* refusal_in(State state) {
  if (state == State::firing) return "a shot is being fired";
  if (state == State::spent) return "the arming is spent: arm again";
  if (state == State::stopped) return "stopped";
  return "not armed";
}

}  // namespace

const char* Interlock::blocked_by_permission(std::uint32_t guards) const noexcept {
  if ((guards & guard::no_fault) != 0 && fault_[0] != '\0') return fault_;
  if ((guards & guard::estop_off) != 0 && estop_) return "the e-stop is pressed";
  if ((guards & guard::key_on) != 0 && !key_) return "the key is off";
  if ((guards & guard::no_stop) != 0 && stop_[0] != '\0')
    return "stopped: a person must give the command to fire anew";
  if ((guards & guard::fault_latched) != 0 && fault_[0] == '\0') return "there is no fault to clear";
  return nullptr;
}

const char* Interlock::blocked_by_request(std::uint32_t guards, const Request& request) const noexcept {
  const auto fails = [guards](std::uint32_t bit, bool holds) { return (guards & bit) != 0 && !holds; };
  if (fails(guard::named_host, request.host != 0 && request.token != 0)) return "the command names no host";
  if (fails(guard::own_arming, state_ != State::armed || host_ == request.host))
    return "another host has armed the rig";
  if (fails(guard::in_time, request.now < expires_)) return "the arming has expired";
  if (fails(guard::token, request.host == host_ && request.token == token_))
    return "the token is not that of the arming";
  if (fails(guard::new_shot, request.shot_id > shot_id_)) return "a shot of this number is spent";
  if (fails(guard::this_shot, request.shot_id == shot_id_)) return "another shot is being fired";
  if (fails(guard::trigger_pending, trigger_pending_)) return "the shot has no trigger left";
  if (fails(guard::after_stops, request.acted > last_stop_))
    return "the rig was stopped, or key or e-stop moved, after this command was given: give it again";
  if (fails(guard::reset_by_host, admitted(request.host)))
    return "stopped: a person must give the command to fire anew at this host";
  if (fails(guard::restart_delay, request.now >= restart_)) return "a stop was reset just now";
  return nullptr;
}

bool Interlock::admitted(std::int64_t host) const noexcept {
  return all_admitted_ || std::find(admitted_.begin(), admitted_.end(), host) != admitted_.end();
}

void Interlock::admit(std::int64_t host) noexcept {
  if (admitted(host)) return;
  admitted_[next_admitted_] = host;
  next_admitted_ = (next_admitted_ + 1) % kMaxAdmitted;
}

void Interlock::drop_token() noexcept {
  host_ = 0;
  token_ = 0;
  expires_ = MonoTime{};
}

void Interlock::perform(std::uint32_t actions, const Request& request, const char* why) noexcept {
  if ((actions & action::drop_token) != 0) drop_token();
  if ((actions & action::take_token) != 0) {
    host_ = request.host;
    token_ = request.token;
    expires_ = request.now + expires_after_;
  }
  if ((actions & action::begin_shot) != 0) {
    shot_id_ = request.shot_id;
    trigger_pending_ = !request.dry;
  }
  if ((actions & action::cancel_trigger) != 0) trigger_pending_ = false;
  if ((actions & action::latch_fault) != 0 && fault_[0] == '\0') fault_ = why;
  if ((actions & action::unlatch_fault) != 0) fault_ = "";
  if ((actions & action::latch_stop) != 0) {
    last_stop_ = request.now;
    admitted_.fill(0);
    all_admitted_ = false;
  }
  if ((actions & action::unlatch_stop) != 0) {
    if (stop_[0] != '\0') restart_ = request.now + kRestartDelay;
    stop_ = "";
    admit(request.host);
  }
}

void Interlock::enter(State next) noexcept {
  const bool rests = next != State::armed && next != State::firing;
  const bool fault = fault_[0] != '\0', stop = stop_[0] != '\0';
  state_ = rests && stop ? State::stopped : rests && fault ? State::fault : next;
}

const char* Interlock::try_transition(InterlockEvent event, const Request& request) noexcept {
  const TransitionRow& rules = row(event);
  if (const char* why = blocked_by_permission(rules.guards)) return why;
  const Transition chosen = transition(event);
  if (chosen.kind != TransitionKind::grant) return refusal_in(state_);
  if (const char* why = blocked_by_request(rules.guards, request)) return why;
  perform(rules.actions, request, "");
  enter(chosen.next);
  return nullptr;
}

Effect Interlock::dispatch(InterlockEvent event, const char* why, MonoTime now) noexcept {
  const Transition chosen = transition(event);
  if (chosen.kind == TransitionKind::refuse) return {};
  Request request;
  request.now = now;
  const bool stops = (row(event).actions & action::latch_stop) != 0;
  if (stops && stop_[0] == '\0') stop_ = stop_words(event);
  perform(row(event).actions, request, why);
  enter(chosen.next);
  if (chosen.kind == TransitionKind::disarm) {
    drop_token();
    return {Effect::Kind::disarmed, why};
  }
  if (chosen.kind == TransitionKind::abort) {
    trigger_pending_ = false;
    return {Effect::Kind::abort, why};
  }
  return {};
}

void Interlock::start(bool key_active, bool estop_active) noexcept {
  key_ = key_active;
  estop_ = estop_active;
  all_admitted_ = key_ && !estop_;
  if (all_admitted_) stop_ = "";
  enter(State::idle);
}

const char* Interlock::arm(std::int64_t host, std::int64_t new_token, MonoTime now) noexcept {
  return try_transition(InterlockEvent::arm, {host, new_token, 0, false, now, {}});
}

const char* Interlock::fire(std::int64_t host, std::int64_t token, std::int32_t shot_id, bool dry,
                            MonoTime now) noexcept {
  return try_transition(InterlockEvent::fire, {host, token, shot_id, dry, now, {}});
}

bool Interlock::release_trigger(std::int32_t shot_id) noexcept {
  return try_transition(InterlockEvent::trigger, {0, 0, shot_id, false, {}, {}}) == nullptr;
}

const char* Interlock::clear() noexcept { return try_transition(InterlockEvent::clear, {}); }

const char* Interlock::reset(std::int64_t host, MonoTime acted, MonoTime now) noexcept {
  constexpr std::int64_t kNoToken = -1;
  return try_transition(InterlockEvent::reset, {host, kNoToken, 0, false, now, acted});
}

Effect Interlock::disarm(MonoTime now) noexcept {
  return dispatch(InterlockEvent::disarm, "disarmed by command", now);
}

Effect Interlock::tick(MonoTime now) noexcept {
  if (state_ != State::armed || now < expires_) return {};
  return dispatch(InterlockEvent::expiry, "the arming has expired", now);
}

Effect Interlock::stood_still() noexcept {
  return dispatch(InterlockEvent::expiry, "the real-time loop stood still while the rig was armed", {});
}

Effect Interlock::key(bool active, MonoTime now) noexcept {
  key_ = active;
  if (active) return dispatch(InterlockEvent::key_on, "the key was turned on", now);
  return dispatch(InterlockEvent::key_off, "the key is off", now);
}

Effect Interlock::estop(bool active, MonoTime now) noexcept {
  estop_ = active;
  if (active) return dispatch(InterlockEvent::estop_on, "the e-stop is pressed", now);
  return dispatch(InterlockEvent::estop_off, "the e-stop was released", now);
}

Effect Interlock::suspended(MonoTime now) noexcept {
  return dispatch(InterlockEvent::suspended, "the rig's computer was suspended", now);
}

Effect Interlock::fault(const char* why) noexcept { return dispatch(InterlockEvent::fault, why, {}); }

}  // namespace strobe::firmware
