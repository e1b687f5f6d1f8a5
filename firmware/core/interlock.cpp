#include "firmware/core/interlock.hpp"

namespace strobe::firmware {

using Kind = Interlock::Effect::Kind;

const char* Interlock::forbidden() const noexcept {
  if (fault_[0] != '\0') return fault_;
  if (estop_) return "the e-stop is pressed";
  if (!key_) return "the key is off";
  return nullptr;
}

void Interlock::drop_token() noexcept {
  host_ = 0;
  token_ = 0;
  expires_ = MonoTime{0};
}

const char* Interlock::arm(std::int64_t host, std::int64_t fresh_token, MonoTime now) noexcept {
  if (const char* why = forbidden()) return why;
  if (state_ == State::firing) return "a shot is being fired";
  if (host == 0 || fresh_token == 0) return "the command names no host";
  if (state_ == State::armed && host_ != host) return "another host has armed";
  state_ = State::armed;
  host_ = host;
  token_ = fresh_token;
  expires_ = now + expires_after_;
  return nullptr;
}

const char* Interlock::fire(std::int64_t host, std::int64_t token, bool dry, MonoTime now) noexcept {
  if (const char* why = forbidden()) return why;
  if (state_ == State::firing) return "a shot is being fired";
  if (state_ != State::armed) return "not armed";
  if (now >= expires_) return "the arming has expired";
  if (host != host_ || token != token_) return "not the token that was given to this host";
  drop_token();
  state_ = State::firing;
  trigger_left_ = !dry;
  return nullptr;
}

Interlock::Effect Interlock::withdraw(const char* why) noexcept {
  if (state_ == State::armed) {
    drop_token();
    state_ = State::idle;
    return {Kind::disarmed, why};
  }
  if (state_ == State::firing) {
    trigger_left_ = false;
    return {Kind::abort, why};
  }
  return {};
}

Interlock::Effect Interlock::disarm() noexcept { return withdraw("disarmed by command"); }

Interlock::Effect Interlock::tick(MonoTime now) noexcept {
  if (state_ != State::armed || now < expires_) return {};
  return withdraw("the arming has expired");
}

Interlock::Effect Interlock::key(bool active) noexcept {
  key_ = active;
  return active ? Effect{} : withdraw("the key is off");
}

Interlock::Effect Interlock::estop(bool active) noexcept {
  estop_ = active;
  return active ? withdraw("the e-stop is pressed") : Effect{};
}

Interlock::Effect Interlock::fault(const char* why) noexcept {
  if (fault_[0] == '\0') fault_ = why;
  const Effect effect = withdraw(why);
  if (state_ != State::firing) state_ = State::fault;
  return effect;
}

const char* Interlock::clear() noexcept {
  if (state_ != State::fault) return "there is no fault to clear";
  fault_ = "";
  state_ = State::idle;
  return nullptr;
}

void Interlock::shot_over() noexcept {
  if (state_ != State::firing) return;
  trigger_left_ = false;
  state_ = fault_[0] != '\0' ? State::fault : State::idle;
}

bool Interlock::release_trigger() noexcept {
  if (state_ != State::firing || !trigger_left_ || forbidden() != nullptr) return false;
  trigger_left_ = false;
  return true;
}

}  // namespace strobe::firmware
