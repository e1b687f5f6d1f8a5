#include "firmware/core/interlock.hpp"

namespace strobe::firmware {

namespace {

using Effect = Interlock::Effect;

const char* refusal_in(State state, LockInput input) {
  if (input == LockInput::clear) return "there is no fault to clear";
  if (state == State::firing) return "a shot is being fired";
  if (state == State::spent) return "the shot is spent: arm for another";
  return "not armed";
}

}  // namespace

const char* Interlock::forbidden(std::uint32_t needs) const noexcept {
  if ((needs & need::no_fault) != 0 && fault_[0] != '\0') return fault_;
  if ((needs & need::estop_off) != 0 && estop_) return "the e-stop is pressed";
  if ((needs & need::key_on) != 0 && !key_) return "the key is off";
  return nullptr;
}

const char* Interlock::missing(std::uint32_t needs, const Request& request) const noexcept {
  const auto lacks = [needs](std::uint32_t bit, bool holds) { return (needs & bit) != 0 && !holds; };
  if (lacks(need::named_host, request.host != 0 && request.token != 0)) return "the command names no host";
  if (lacks(need::own_arming, state_ != State::armed || host_ == request.host))
    return "another host has armed";
  if (lacks(need::in_time, request.now < expires_)) return "the arming has expired";
  if (lacks(need::token, request.host == host_ && request.token == token_))
    return "not the token that was given to this host";
  if (lacks(need::new_shot, request.shot_id > shot_id_)) return "a shot of this number is spent";
  if (lacks(need::this_shot, request.shot_id == shot_id_)) return "another shot is being fired";
  if (lacks(need::trigger_left, trigger_left_)) return "the shot has no trigger left";
  return nullptr;
}

void Interlock::drop_token() noexcept {
  host_ = 0;
  token_ = 0;
  expires_ = MonoTime{0};
}

void Interlock::perform(std::uint32_t deeds, const Request& request, const char* why) noexcept {
  if ((deeds & deed::drop_token) != 0) drop_token();
  if ((deeds & deed::take_token) != 0) {
    host_ = request.host;
    token_ = request.token;
    expires_ = request.now + expires_after_;
  }
  if ((deeds & deed::begin_shot) != 0) {
    shot_id_ = request.shot_id;
    trigger_left_ = !request.dry;
  }
  if ((deeds & deed::withhold_trigger) != 0) trigger_left_ = false;
  if ((deeds & deed::latch_fault) != 0 && fault_[0] == '\0') fault_ = why;
  if ((deeds & deed::unlatch_fault) != 0) fault_ = "";
}

void Interlock::enter(State next) noexcept {
  const bool latched = fault_[0] != '\0';
  state_ = latched && (next == State::idle || next == State::spent) ? State::fault : next;
}

const char* Interlock::ask(LockInput input, const Request& request) noexcept {
  const LockRow& rules = row(input);
  if (const char* why = forbidden(rules.needs)) return why;
  const LockCell answer = cell(input);
  if (answer.answer != Answer::grant) return refusal_in(state_, input);
  if (const char* why = missing(rules.needs, request)) return why;
  perform(rules.deeds, request, "");
  enter(answer.next);
  return nullptr;
}

Effect Interlock::obey(LockInput input, const char* why) noexcept {
  const LockCell answer = cell(input);
  if (answer.answer == Answer::refuse) return {};
  perform(row(input).deeds, {}, why);
  enter(answer.next);
  if (answer.answer == Answer::disarm) {
    drop_token();
    return {Effect::Kind::disarmed, why};
  }
  if (answer.answer == Answer::abort) {
    trigger_left_ = false;
    return {Effect::Kind::abort, why};
  }
  return {};
}

const char* Interlock::arm(std::int64_t host, std::int64_t fresh_token, MonoTime now) noexcept {
  return ask(LockInput::arm, {host, fresh_token, 0, false, now});
}

const char* Interlock::fire(std::int64_t host, std::int64_t token, std::int32_t shot_id, bool dry,
                            MonoTime now) noexcept {
  return ask(LockInput::fire, {host, token, shot_id, dry, now});
}

bool Interlock::release_trigger(std::int32_t shot_id) noexcept {
  return ask(LockInput::trigger, {0, 0, shot_id, false, {}}) == nullptr;
}

const char* Interlock::clear() noexcept { return ask(LockInput::clear, {}); }

Effect Interlock::disarm() noexcept { return obey(LockInput::disarm, "disarmed by command"); }

Effect Interlock::tick(MonoTime now) noexcept {
  if (state_ != State::armed || now < expires_) return {};
  return obey(LockInput::expiry, "the arming has expired");
}

Effect Interlock::key(bool active) noexcept {
  key_ = active;
  return obey(active ? LockInput::key_on : LockInput::key_off, "the key is off");
}

Effect Interlock::estop(bool active) noexcept {
  estop_ = active;
  return obey(active ? LockInput::estop_on : LockInput::estop_off, "the e-stop is pressed");
}

Effect Interlock::fault(const char* why) noexcept { return obey(LockInput::fault, why); }

}  // namespace strobe::firmware
