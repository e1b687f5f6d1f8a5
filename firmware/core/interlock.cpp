#include "firmware/core/interlock.hpp"

namespace strobe::firmware {

namespace {

using Effect = Interlock::Effect;

const char* refusal_in(State state, InterlockEvent event) {
  if (event == InterlockEvent::clear) return "there is no fault to clear";
  if (state == State::firing) return "a shot is being fired";
  if (state == State::spent) return "the shot is spent: arm for another";
  return "not armed";
}

}  // namespace

const char* Interlock::blocked_by_permission(std::uint32_t guards) const noexcept {
  if ((guards & guard::no_fault) != 0 && fault_[0] != '\0') return fault_;
  if ((guards & guard::estop_off) != 0 && estop_) return "the e-stop is pressed";
  if ((guards & guard::key_on) != 0 && !key_) return "the key is off";
  return nullptr;
}

const char* Interlock::blocked_by_request(std::uint32_t guards, const Request& request) const noexcept {
  const auto fails = [guards](std::uint32_t bit, bool holds) { return (guards & bit) != 0 && !holds; };
  if (fails(guard::named_host, request.host != 0 && request.token != 0)) return "the command names no host";
  if (fails(guard::own_arming, state_ != State::armed || host_ == request.host))
    return "another host has armed";
  if (fails(guard::in_time, request.now < expires_)) return "the arming has expired";
  if (fails(guard::token, request.host == host_ && request.token == token_))
    return "not the token that was given to this host";
  if (fails(guard::new_shot, request.shot_id > shot_id_)) return "a shot of this number is spent";
  if (fails(guard::this_shot, request.shot_id == shot_id_)) return "another shot is being fired";
  if (fails(guard::trigger_pending, trigger_pending_)) return "the shot has no trigger left";
  return nullptr;
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
}

void Interlock::enter(State next) noexcept {
  const bool latched = fault_[0] != '\0';
  state_ = latched && (next == State::idle || next == State::spent) ? State::fault : next;
}

const char* Interlock::try_transition(InterlockEvent event, const Request& request) noexcept {
  const TransitionRow& rules = row(event);
  if (const char* why = blocked_by_permission(rules.guards)) return why;
  const Transition chosen = transition(event);
  if (chosen.kind != TransitionKind::grant) return refusal_in(state_, event);
  if (const char* why = blocked_by_request(rules.guards, request)) return why;
  perform(rules.actions, request, "");
  enter(chosen.next);
  return nullptr;
}

Effect Interlock::dispatch(InterlockEvent event, const char* why) noexcept {
  const Transition chosen = transition(event);
  if (chosen.kind == TransitionKind::refuse) return {};
  perform(row(event).actions, {}, why);
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

const char* Interlock::arm(std::int64_t host, std::int64_t new_token, MonoTime now) noexcept {
  return try_transition(InterlockEvent::arm, {host, new_token, 0, false, now});
}

const char* Interlock::fire(std::int64_t host, std::int64_t token, std::int32_t shot_id, bool dry,
                            MonoTime now) noexcept {
  return try_transition(InterlockEvent::fire, {host, token, shot_id, dry, now});
}

bool Interlock::release_trigger(std::int32_t shot_id) noexcept {
  return try_transition(InterlockEvent::trigger, {0, 0, shot_id, false, {}}) == nullptr;
}

const char* Interlock::clear() noexcept { return try_transition(InterlockEvent::clear, {}); }

Effect Interlock::disarm() noexcept { return dispatch(InterlockEvent::disarm, "disarmed by command"); }

Effect Interlock::tick(MonoTime now) noexcept {
  if (state_ != State::armed || now < expires_) return {};
  return dispatch(InterlockEvent::expiry, "the arming has expired");
}

Effect Interlock::key(bool active) noexcept {
  key_ = active;
  return dispatch(active ? InterlockEvent::key_on : InterlockEvent::key_off, "the key is off");
}

Effect Interlock::estop(bool active) noexcept {
  estop_ = active;
  return dispatch(active ? InterlockEvent::estop_on : InterlockEvent::estop_off, "the e-stop is pressed");
}

Effect Interlock::fault(const char* why) noexcept { return dispatch(InterlockEvent::fault, why); }

}  // namespace strobe::firmware
