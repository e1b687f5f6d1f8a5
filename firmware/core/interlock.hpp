// The interlock: who may fire, and when. A state machine without clock, I/O or allocation that Sequencer and
// ShotPlayer run by. The table below decides on every event in every state; nothing else does.
//
// Its safety invariants, proved in tests/firmware over all reachable states:
//  1. The trigger is released only in state `firing`, once per shot, for the shot that was granted, while the
//     key is on, the e-stop released and no fault latched; never in a dry or aborted shot.
//  2. A shot is granted only to the host that armed, with the newest token it was given, before that expired,
//     and only under a number that no shot had before. The shot uses the token up: fired or aborted, it is
//     spent.
//  3. Key off, e-stop, disarm, a suspended machine and fault end an arming and abort a shot, in whatever
//  state, within
//     that call.
//  4. A fault stays latched until CLEAR; nothing is armed, granted or released while it is.
//  5. A stop (key off, e-stop, disarm, a suspended machine, also the return of key or e-stop) stays latched
//  until RESET,
//     which a person must have given after it, with the key on and the e-stop released; kRestartDelay later
//     at the soonest a host may arm, and only one that gave a RESET of its own since (ISO 13850: the release
//     of an emergency stop must not start anything).
//
// All calls are real-time safe; one thread's. Refusals are texts in static storage; nullptr means granted.
#pragma once

#include <array>
#include <cstdint>

#include "common/units/time.hpp"
#include "firmware/ports/event_sink.hpp"

namespace strobe::firmware {

enum class InterlockEvent : std::uint8_t {
  arm,
  fire,
  disarm,
  expiry,
  key_off,
  key_on,
  estop_on,
  estop_off,
  suspended,  ///< the machine slept
  fault,
  clear,
  reset,
  trigger,  ///< the shot's instant for the machine's pulse has come
  aborted,  ///< the shot was aborted for a reason of its own (late, a failed line)
  shot_over
};
inline constexpr std::size_t kInterlockEventCount = 15;
inline constexpr std::size_t kStateCount = 6;

/// Conditions for a grant, besides the state.
namespace guard {
inline constexpr std::uint32_t no_fault = 1U << 0;
inline constexpr std::uint32_t estop_off = 1U << 1;
inline constexpr std::uint32_t key_on = 1U << 2;
inline constexpr std::uint32_t no_stop = 1U << 3;
inline constexpr std::uint32_t permission = no_fault | no_stop | estop_off | key_on;
inline constexpr std::uint32_t named_host = 1U << 10;      ///< host and new token are not 0
inline constexpr std::uint32_t own_arming = 1U << 4;       ///< not armed by another host
inline constexpr std::uint32_t in_time = 1U << 5;          ///< the arming has not expired
inline constexpr std::uint32_t token = 1U << 6;            ///< the arming's host and token
inline constexpr std::uint32_t new_shot = 1U << 7;         ///< a number above every shot before
inline constexpr std::uint32_t this_shot = 1U << 8;        ///< the number of the shot that is being fired
inline constexpr std::uint32_t trigger_pending = 1U << 9;  ///< not dry, not aborted, not yet released
inline constexpr std::uint32_t fault_latched = 1U << 11;
inline constexpr std::uint32_t after_stops = 1U << 12;    ///< a person acted after the last stop
inline constexpr std::uint32_t reset_by_host = 1U << 13;  ///< since the last stop, if there was one
inline constexpr std::uint32_t restart_delay = 1U << 14;  ///< is over
}  // namespace guard

/// What a transition does unless it is refused, besides the change of state.
namespace action {
inline constexpr std::uint32_t take_token = 1U << 0;
inline constexpr std::uint32_t drop_token = 1U << 1;
/// uses its number up; its trigger is pending unless dry
inline constexpr std::uint32_t begin_shot = 1U << 2;
inline constexpr std::uint32_t cancel_trigger = 1U << 3;
inline constexpr std::uint32_t latch_fault = 1U << 4;
inline constexpr std::uint32_t unlatch_fault = 1U << 5;
inline constexpr std::uint32_t latch_stop = 1U << 6;    ///< whoever has reset one has to do so again
inline constexpr std::uint32_t unlatch_stop = 1U << 7;  ///< admits the host
}  // namespace action

/// disarm also drops the token, abort also cancels the trigger.
enum class TransitionKind : std::uint8_t { none, grant, refuse, disarm, abort };

struct Transition {
  TransitionKind kind;
  State next;
};

struct TransitionRow {
  std::uint32_t guards = 0;                  ///< bits of guard, for a grant
  std::uint32_t actions = 0;                 ///< bits of action
  std::array<Transition, kStateCount> in{};  ///< indexed by State
};

using TransitionTable = std::array<TransitionRow, kInterlockEventCount>;  ///< indexed by InterlockEvent

// clang-format off
/// As long as a stop is latched, the next state of what comes to rest is `stopped`; else, of a fault, `fault`.
inline constexpr TransitionTable kTransitionTable = [] {
  using enum TransitionKind;
  constexpr State idle = State::idle, armed = State::armed, firing = State::firing, broken = State::fault,
                  spent = State::spent, stopped = State::stopped;
  namespace g = guard;
  namespace a = action;
  return TransitionTable{{
  //                                                                 in idle           armed              firing            fault             spent             stopped
  /* arm       */ {g::permission | g::named_host | g::own_arming | g::reset_by_host | g::restart_delay,
                   a::take_token,                                 {{{grant, armed},   {grant, armed},    {refuse, firing}, {refuse, broken}, {grant, armed},   {refuse, stopped}}}},
  /* fire      */ {g::permission | g::in_time | g::token | g::new_shot,
                   a::drop_token | a::begin_shot,                 {{{refuse, idle},   {grant, firing},   {refuse, firing}, {refuse, broken}, {refuse, spent},  {refuse, stopped}}}},
  /* disarm    */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* expiry    */ {0, 0,                                          {{{none, idle},     {disarm, idle},    {none, firing},   {none, broken},   {none, spent},    {none, stopped}}}},
  /* key_off   */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* key_on    */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* estop_on  */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* estop_off */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* suspended */ {0, a::latch_stop,                              {{{none, stopped},  {disarm, stopped}, {abort, firing},  {none, stopped},  {none, stopped},  {none, stopped}}}},
  /* fault     */ {0, a::latch_fault,                             {{{none, broken},   {disarm, broken},  {abort, firing},  {none, broken},   {none, broken},   {none, stopped}}}},
  /* clear     */ {g::fault_latched, a::unlatch_fault,            {{{refuse, idle},   {refuse, armed},   {refuse, firing}, {grant, idle},    {refuse, spent},  {grant, stopped}}}},
  /* reset     */ {g::estop_off | g::key_on | g::named_host | g::after_stops,
                   a::unlatch_stop,                               {{{grant, idle},    {grant, armed},    {refuse, firing}, {grant, broken},  {grant, spent},   {grant, idle}}}},
  /* trigger   */ {g::permission | g::this_shot | g::trigger_pending,
                   a::cancel_trigger,                             {{{refuse, idle},   {refuse, armed},   {grant, firing},  {refuse, broken}, {refuse, spent},  {refuse, stopped}}}},
  /* aborted   */ {0, a::cancel_trigger,                          {{{none, idle},     {none, armed},     {none, firing},   {none, broken},   {none, spent},    {none, stopped}}}},
  /* shot_over */ {0, a::cancel_trigger,                          {{{none, idle},     {none, armed},     {none, spent},    {none, broken},   {none, spent},    {none, stopped}}}},
  }};
}();
// clang-format on

class Interlock {
 public:
  /// From a RESET that ends a stop to the first ARM that may be granted.
  static constexpr Duration kRestartDelay = milliseconds(1000);

  /// last_shot_id: the highest number that any shot had. table: must outlive this; tests give wrong ones, to
  /// prove that they would be noticed.
  explicit Interlock(Duration arming_expires, std::int32_t last_shot_id = 0,
                     const TransitionTable& table = kTransitionTable)
      : table_(&table), expires_after_(arming_expires), shot_id_(last_shot_id) {}

  /// What the caller has to do after an event, and why.
  struct Effect {
    enum class Kind { none, disarmed, abort } kind = Kind::none;
    const char* why = "";
  };

  /// The levels at the start: where they are permissive, nothing has to be reset. Else it begins stopped.
  void start(bool key_active, bool estop_active) noexcept;

  const char* arm(std::int64_t host, std::int64_t new_token, MonoTime now) noexcept;
  /// shot_id: the number that the shot will have.
  const char* fire(std::int64_t host, std::int64_t token, std::int32_t shot_id, bool dry,
                   MonoTime now) noexcept;
  Effect disarm(MonoTime now) noexcept;
  Effect tick(MonoTime now) noexcept;  ///< expiry
  Effect stood_still() noexcept;  ///< the loop, for so long that nobody knows what an arming is still worth
  Effect key(bool active, MonoTime now) noexcept;
  Effect estop(bool active, MonoTime now) noexcept;
  Effect suspended(MonoTime now) noexcept;
  Effect fault(const char* why) noexcept;  ///< latches the first; `why` in static storage
  const char* clear() noexcept;
  /// acted: when a person asked for it.
  const char* reset(std::int64_t host, MonoTime acted, MonoTime now) noexcept;
  void aborted() noexcept { dispatch(InterlockEvent::aborted, "", {}); }
  void shot_over() noexcept { dispatch(InterlockEvent::shot_over, "", {}); }

  /// Returns true at most once per shot: the trigger's pulse may be issued now.
  bool release_trigger(std::int32_t shot_id) noexcept;

  State state() const noexcept { return state_; }
  bool key_active() const noexcept { return key_; }
  bool estop_active() const noexcept { return estop_; }
  std::int64_t arm_host() const noexcept { return host_; }  ///< 0 if not armed
  std::int64_t arm_token() const noexcept { return token_; }
  MonoTime arm_expires() const noexcept { return expires_; }
  std::int32_t shot_id() const noexcept { return shot_id_; }  ///< the highest number used
  bool trigger_pending() const noexcept { return trigger_pending_; }
  const char* fault_text() const noexcept { return fault_; }  ///< "": none
  const char* stop_text() const noexcept { return stop_; }    ///< of the stop that is latched; "": none
  MonoTime restart() const noexcept { return restart_; }      ///< nothing is armed before
  bool admitted(std::int64_t host) const noexcept;            ///< has reset the last stop, if there was one

 private:
  struct Request {
    std::int64_t host = 0;
    std::int64_t token = 0;
    std::int32_t shot_id = 0;
    bool dry = false;
    MonoTime now;
    MonoTime acted;
  };
  const TransitionRow& row(InterlockEvent event) const noexcept {
    return (*table_)[static_cast<std::size_t>(event)];
  }
  const Transition& transition(InterlockEvent event) const noexcept {
    return row(event).in[static_cast<std::size_t>(state_)];
  }
  const char* try_transition(InterlockEvent event, const Request& request) noexcept;
  Effect dispatch(InterlockEvent event, const char* why, MonoTime now) noexcept;
  const char* blocked_by_permission(std::uint32_t guards) const noexcept;
  const char* blocked_by_request(std::uint32_t guards, const Request& request) const noexcept;
  void perform(std::uint32_t actions, const Request& request, const char* why) noexcept;
  void enter(State next) noexcept;
  void drop_token() noexcept;
  void admit(std::int64_t host) noexcept;

  static constexpr std::size_t kMaxAdmitted = 16;  ///< the one that acted longest ago is forgotten first
  const TransitionTable* table_;
  Duration expires_after_{};
  State state_ = State::stopped;
  bool key_ = false;
  bool estop_ = true;
  bool trigger_pending_ = false;
  std::int64_t host_ = 0;
  std::int64_t token_ = 0;
  MonoTime expires_{};
  std::int32_t shot_id_;
  const char* fault_ = "";
  const char* stop_ = "the key was off, or the e-stop pressed, as strobed started";
  MonoTime last_stop_{};  ///< the last that had to do with a stop, the return of a switch included
  MonoTime restart_{};
  std::array<std::int64_t, kMaxAdmitted> admitted_{};  ///< hosts; 0: nobody
  std::size_t next_admitted_ = 0;
  bool all_admitted_ = false;  ///< no stop since the start
};

}  // namespace strobe::firmware
