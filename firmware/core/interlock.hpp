// Who may fire, and when. An explicit state machine without clock, I/O or allocation:
//
//   state   ARM                FIRE (token)       DISARM, expiry, key off, e-stop   fault    shot over CLEAR
//   idle    armed (permitted)  refused            idle                              fault    - refused armed
//   new token          firing, token gone idle                              fault    -           refused
//   firing  refused            refused            firing, shot aborted              firing*  idle refused
//   fault   refused            refused            fault                             fault    -           idle
//
// * aborted; fault as soon as the shot is over. "Permitted": key active, e-stop inactive, no fault.
// The trigger is released at most once per FIRE, and only while firing, not aborted, key on, e-stop off, not
// dry. All calls are real-time safe; one thread's. Refusals are words (static storage); nullptr is "granted".
#pragma once

#include <cstdint>

#include "common/units/time.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

class Interlock {
 public:
  explicit Interlock(Duration arming_expires) : expires_after_(arming_expires) {}

  /// What the caller has to do after an input: at most one of them, with the reason in words.
  struct Effect {
    enum class Kind { none, disarmed, abort } kind = Kind::none;
    const char* why = "";
  };

  const char* arm(std::int64_t host, std::int64_t fresh_token, MonoTime now) noexcept;
  const char* fire(std::int64_t host, std::int64_t token, bool dry, MonoTime now) noexcept;
  Effect disarm() noexcept;
  Effect tick(MonoTime now) noexcept;  ///< expiry
  Effect key(bool active) noexcept;
  Effect estop(bool active) noexcept;
  Effect fault(const char* why) noexcept;  ///< latches the first; `why` in static storage
  const char* clear() noexcept;
  void aborted() noexcept { trigger_left_ = false; }  ///< the shot was aborted for another reason
  void shot_over() noexcept;

  /// True once per shot at most; then the trigger's pulse may be issued, now.
  bool release_trigger() noexcept;

  State state() const noexcept { return state_; }
  bool key_active() const noexcept { return key_; }
  bool estop_active() const noexcept { return estop_; }
  std::int64_t arm_host() const noexcept { return host_; }
  std::int64_t arm_token() const noexcept { return token_; }
  MonoTime arm_expires() const noexcept { return expires_; }
  const char* fault_words() const noexcept { return fault_; }  ///< "": none

 private:
  const char* forbidden() const noexcept;
  Effect withdraw(const char* why) noexcept;
  void drop_token() noexcept;

  Duration expires_after_;
  State state_ = State::idle;
  bool key_ = false;
  bool estop_ = true;
  bool trigger_left_ = false;
  std::int64_t host_ = 0;
  std::int64_t token_ = 0;
  MonoTime expires_{0};
  const char* fault_ = "";
};

}  // namespace strobe::firmware
