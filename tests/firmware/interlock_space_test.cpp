// The interlock's whole state space: every input in every state that can be reached, beside a judge who knows
// only what was put in and what was answered. The search ends when no new state turns up, so it holds for
// sequences of any length; and every single change of the interlock's table is put to the same judge, to
// prove that it would notice.
#include <array>
#include <cstdio>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "firmware/core/interlock.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;

namespace {

constexpr Duration kExpires = milliseconds(30'000);
constexpr std::int64_t kHost = 11, kOther = 22;

enum class In {
  arm,
  arm_other,     ///< another host than kHost
  arm_nameless,  ///< host 0
  arm_tokenless,
  fire,  ///< by the host that is armed, with its token
  fire_dry,
  fire_old,  ///< with the token that was current before
  fire_guessed,
  fire_foreign,  ///< right token, another host
  fire_used,     ///< right token, but the number of the last shot
  disarm,
  time_passes,  ///< until the arming is over, unnoticed so far
  tick,
  key_off,
  key_on,
  estop_on,
  estop_off,
  suspended,
  stood_still,
  fault,
  clear,
  reset,         ///< a person at kHost acts, after all stops
  reset_other,   ///< likewise at another host
  reset_before,  ///< the person acted at the instant of the last stop
  delay_passes,  ///< since a stop was reset
  trigger,
  trigger_used,  ///< for the shot before
  aborted,
  shot_over,
  count
};
constexpr int kInputs = static_cast<int>(In::count);

/// What may be known from outside, and what follows from it.
struct Judge {
  bool key = false, estop = true, latched = false;
  std::int64_t host = 0;  ///< that armed and may still fire; 0: none
  std::int64_t token = 0, old_token = 0;
  bool expired = false;
  bool running = false;  ///< a shot was granted and is not over
  bool live = false;     ///< and is neither dry nor aborted nor was its trigger released
  bool spent = false;    ///< the last thing was a shot
  std::int32_t shot = 0;
  bool stopped = true;              ///< and no person has acted since
  std::set<std::int64_t> admitted;  ///< hosts of persons who have acted since the last stop
  bool delayed = false;             ///< a stop was reset, and the delay is not over
  MonoTime last_stop;

  bool permitted() const { return key && !estop && !latched && !stopped; }
  void withdraw() {
    host = 0;
    live = false;
  }
  State state() const {
    if (running) return State::firing;
    if (stopped) return State::stopped;
    if (latched) return State::fault;
    if (host != 0) return State::armed;
    return spent ? State::spent : State::idle;
  }
};

struct Walk {
  Interlock lock;
  Judge judge;
  MonoTime now = from_ns(1'000'000'000);
  std::int64_t next_token = 1;
};

using Complaint = std::optional<std::string>;
using Kind = Interlock::Effect::Kind;

Complaint expect(bool holds, const char* rule) { return holds ? Complaint{} : Complaint{rule}; }

Complaint arm(Walk& walk, std::int64_t host, bool with_token) {
  Judge& judge = walk.judge;
  const std::int64_t token = with_token ? walk.next_token++ : 0;
  const bool granted = walk.lock.arm(host, token, walk.now) == nullptr;
  const bool may = judge.permitted() && !judge.running && host != 0 && token != 0 &&
                   (judge.host == 0 || judge.host == host) && judge.admitted.contains(host) && !judge.delayed;
  if (granted && may) {
    judge.old_token = judge.token;
    judge.token = token;
    judge.host = host;
    judge.expired = judge.spent = false;
  }
  return expect(granted == may, granted ? "armed without permission" : "not armed with permission");
}

Complaint fire(Walk& walk, std::int64_t host, std::int64_t token, std::int32_t shot, bool dry) {
  Judge& judge = walk.judge;
  const bool granted = walk.lock.fire(host, token, shot, dry, walk.now) == nullptr;
  const bool may = judge.permitted() && judge.host != 0 && !judge.expired && !judge.running &&
                   host == judge.host && token == judge.token && shot > judge.shot;
  if (granted && may) {
    judge.host = 0;
    judge.running = true;
    judge.live = !dry;
    judge.shot = shot;
  }
  return expect(granted == may, granted ? "granted a shot without right" : "refused a shot of good right");
}

Complaint withdrawn(Walk& walk, Interlock::Effect effect) {
  Judge& judge = walk.judge;
  const Kind due = judge.running ? Kind::abort : judge.host != 0 ? Kind::disarmed : Kind::none;
  judge.withdraw();
  return expect(effect.kind == due, "an arming or a shot was not withdrawn at once, or none was there");
}

/// Whatever it is, later than all before.
MonoTime next_instant(Walk& walk) { return walk.now = walk.now + nanoseconds(1); }

Complaint stopped(Walk& walk, Interlock::Effect effect) {
  walk.judge.stopped = true;
  walk.judge.admitted.clear();
  walk.judge.last_stop = walk.now;
  return withdrawn(walk, effect);
}

Complaint reset(Walk& walk, std::int64_t host, bool after) {
  Judge& judge = walk.judge;
  const MonoTime acted = after ? next_instant(walk) : judge.last_stop;
  const bool granted = walk.lock.reset(host, acted, walk.now) == nullptr;
  const bool may = judge.key && !judge.estop && after && !judge.running;
  if (may && judge.stopped) {
    judge.spent = judge.stopped = false;
    judge.delayed = true;
  }
  if (may) judge.admitted.insert(host);
  return expect(granted == may,
                granted ? "A STOP WAS RESET WITHOUT RIGHT" : "a reset of good right was refused");
}

Complaint release(Walk& walk, std::int32_t shot) {
  Judge& judge = walk.judge;
  const bool released = walk.lock.release_trigger(shot);
  const bool may = judge.running && judge.live && judge.permitted() && shot == judge.shot;
  if (released) judge.live = false;
  return expect(released == may,
                released ? "THE TRIGGER WAS RELEASED WITHOUT RIGHT" : "the trigger was withheld");
}

Complaint none(Interlock::Effect effect) {
  return expect(effect.kind == Kind::none, "an effect without a cause");
}

Complaint put_in(Walk& walk, In input) {
  Judge& judge = walk.judge;
  const std::int64_t holder = judge.host != 0 ? judge.host : kHost;
  const std::int32_t next = judge.shot + 1;
  switch (input) {
    case In::arm:
      return arm(walk, kHost, true);
    case In::arm_other:
      return arm(walk, kOther, true);
    case In::arm_nameless:
      return arm(walk, 0, true);
    case In::arm_tokenless:
      return arm(walk, kHost, false);
    case In::fire:
      return fire(walk, holder, judge.token, next, false);
    case In::fire_dry:
      return fire(walk, holder, judge.token, next, true);
    case In::fire_old:
      return fire(walk, holder, judge.old_token, next, false);
    case In::fire_guessed:
      return fire(walk, holder, 0, next, false);
    case In::fire_foreign:
      return fire(walk, holder == kHost ? kOther : kHost, judge.token, next, false);
    case In::fire_used:
      return fire(walk, holder, judge.token, judge.shot, false);
    case In::disarm:
      return stopped(walk, walk.lock.disarm(next_instant(walk)));
    case In::time_passes:
      walk.now = walk.now + kExpires;
      judge.expired = judge.host != 0;
      judge.delayed = false;
      return {};
    case In::tick: {
      const Interlock::Effect effect = walk.lock.tick(walk.now);
      if (judge.host == 0 || !judge.expired) return none(effect);
      return withdrawn(walk, effect);
    }
    case In::key_off:
    case In::key_on:
      judge.key = input == In::key_on;
      return stopped(walk, walk.lock.key(judge.key, next_instant(walk)));
    case In::estop_on:
    case In::estop_off:
      judge.estop = input == In::estop_on;
      return stopped(walk, walk.lock.estop(judge.estop, next_instant(walk)));
    case In::suspended:
      return stopped(walk, walk.lock.suspended(next_instant(walk)));
    case In::stood_still: {
      const Interlock::Effect effect = walk.lock.stood_still();
      return judge.host == 0 ? none(effect) : withdrawn(walk, effect);
    }
    case In::reset:
      return reset(walk, kHost, true);
    case In::reset_other:
      return reset(walk, kOther, true);
    case In::reset_before:
      return reset(walk, kHost, false);
    case In::delay_passes:
      walk.now = walk.now + Interlock::kRestartDelay;
      judge.delayed = false;
      return {};
    case In::fault:
      judge.latched = true;
      return withdrawn(walk, walk.lock.fault("broken"));
    case In::clear: {
      const bool may = judge.latched && !judge.running;
      if (may) judge.latched = judge.spent = false;
      return expect((walk.lock.clear() == nullptr) == may, "a fault was cleared wrongly, or not");
    }
    case In::trigger:
      return release(walk, judge.shot);
    case In::trigger_used:
      return release(walk, judge.shot - 1);
    case In::aborted:
      judge.live = false;
      walk.lock.aborted();
      return {};
    case In::shot_over:
      walk.lock.shot_over();
      if (judge.running) judge.spent = true;
      judge.running = judge.live = false;
      return {};
    case In::count:
      break;
  }
  return {};
}

/// What must be so in every state, whatever led there.
Complaint inspect(const Walk& walk) {
  const Interlock& lock = walk.lock;
  const Judge& judge = walk.judge;
  if (lock.state() != judge.state()) return "another state than the history says";
  if (lock.key_active() != judge.key || lock.estop_active() != judge.estop) return "key or e-stop forgotten";
  if ((lock.fault_text()[0] != '\0') != judge.latched) return "a fault was forgotten, or made up";
  if (lock.arm_host() != judge.host) return "a token that nobody should have, or the reverse";
  if (judge.host != 0 && lock.arm_token() != judge.token) return "another token than the last";
  if (judge.host == 0 && lock.arm_token() != 0) return "a token without a host";
  if (lock.shot_id() != judge.shot) return "another number of the last shot";
  if ((lock.stop_text()[0] != '\0') != judge.stopped) return "a stop was forgotten, or made up";
  // Whatever comes next, a stop takes effect in one call.
  for (const bool by_key : {true, false}) {
    Interlock stopped = lock;
    by_key ? stopped.key(false, walk.now) : stopped.estop(true, walk.now);
    if (stopped.release_trigger(stopped.shot_id())) return "THE TRIGGER WAS RELEASED AFTER A STOP";
    if (stopped.state() == State::armed) return "armed after a stop";
  }
  return {};
}

/// All that future answers depend on: times and numbers only as far as they are compared.
using Key = std::tuple<int, bool, bool, bool, bool, std::int64_t, bool, bool, bool, bool, bool, bool, bool,
                       bool, bool, bool>;
Key key_of(const Walk& walk) {
  const Interlock& lock = walk.lock;
  const Judge& judge = walk.judge;
  return {static_cast<int>(lock.state()),
          lock.key_active(),
          lock.estop_active(),
          lock.fault_text()[0] != '\0',
          lock.trigger_pending(),
          lock.arm_host(),
          lock.arm_token() == judge.token,
          walk.now >= lock.arm_expires(),
          judge.token != judge.old_token && judge.old_token != 0,
          judge.live,
          judge.spent,
          judge.shot > 0,
          judge.stopped,
          judge.admitted.contains(kHost),
          judge.admitted.contains(kOther),
          walk.now >= lock.restart()};
}

struct Found {
  std::size_t states = 0, transitions = 0;
  std::size_t depth = 0;  ///< of the state that takes the longest sequence
  std::size_t released = 0;
  std::array<std::size_t, kStateCount> of_state{};
  std::string complaint;  ///< with the shortest sequence that leads to it; empty: none
};

struct Place {
  Walk walk;
  std::vector<In> path;
};

std::string complaint_text(const std::string& complaint, const std::vector<In>& path, In last) {
  std::string text = complaint + " after inputs";
  for (const In input : path) text += " " + std::to_string(static_cast<int>(input));
  return text + " " + std::to_string(static_cast<int>(last));
}

enum class Severity { all, trigger_without_permission };

Found search(const TransitionTable& table, Severity severity = Severity::all) {
  Found found;
  std::map<Key, bool> known;
  std::deque<Place> open;
  Place start{{Interlock{kExpires, 0, table}, {}}, {}};
  known[key_of(start.walk)] = true;
  open.push_back(start);
  while (!open.empty()) {
    const Place place = open.front();
    open.pop_front();
    ++found.states;
    ++found.of_state[static_cast<std::size_t>(place.walk.lock.state())];
    found.depth = place.path.size();
    for (int i = 0; i < kInputs; ++i) {
      Place next = place;
      const In input = static_cast<In>(i);
      const bool left = next.walk.lock.trigger_pending();
      Complaint complaint = put_in(next.walk, input);
      if (!complaint) complaint = inspect(next.walk);
      ++found.transitions;
      const bool released = left && input == In::trigger && !next.walk.lock.trigger_pending();
      if (severity == Severity::trigger_without_permission)
        complaint = expect(!released || next.walk.judge.permitted(), "RELEASED WITHOUT PERMISSION");
      if (complaint) {
        found.complaint = complaint_text(*complaint, place.path, input);
        return found;
      }
      if (released) ++found.released;
      if (!known.emplace(key_of(next.walk), true).second) continue;
      next.path.push_back(input);
      open.push_back(std::move(next));
    }
  }
  return found;
}

/// Without remembering what was seen: proves that key_of() forgets nothing that matters.
Complaint try_all(const Walk& walk, int depth, std::size_t& sequences) {
  ++sequences;
  if (depth == 0) return {};
  for (int i = 0; i < kInputs; ++i) {
    Walk next = walk;
    Complaint complaint = put_in(next, static_cast<In>(i));
    if (!complaint) complaint = inspect(next);
    if (!complaint) complaint = try_all(next, depth - 1, sequences);
    if (complaint) return complaint;
  }
  return {};
}

struct Mutants {
  int made = 0, noticed = 0;

  void judge(const TransitionTable& table) {
    ++made;
    if (!search(table).complaint.empty()) ++noticed;
  }
};

/// Inputs that may be refused; all others are facts.
bool is_asked(std::size_t input) {
  const auto which = static_cast<InterlockEvent>(input);
  return which == InterlockEvent::arm || which == InterlockEvent::fire || which == InterlockEvent::clear ||
         which == InterlockEvent::reset || which == InterlockEvent::trigger;
}

bool notices_without(InterlockEvent input, std::uint32_t guards) {
  TransitionTable table = kTransitionTable;
  table[static_cast<std::size_t>(input)].guards &= ~guards;
  return !search(table).complaint.empty();
}

}  // namespace

TEST_GROUP(InterlockSpace){};

TEST(InterlockSpace, KeepsEveryRuleInEveryStateThatCanBeReached) {
  const Found found = search(kTransitionTable);
  std::printf(
      "interlock: %zu states (idle %zu, armed %zu, firing %zu, fault %zu, spent %zu, stopped %zu), %zu "
      "transitions, "
      "closed "
      "at depth %zu\n",
      found.states, found.of_state[0], found.of_state[1], found.of_state[2], found.of_state[3],
      found.of_state[4], found.of_state[5], found.transitions, found.depth);
  CHECK_EQUAL("", found.complaint);
  CHECK(found.released > 0);  // the rules are not kept by never firing at all
  for (const std::size_t states : found.of_state) CHECK(states > 0);
}

TEST(InterlockSpace, KeepsThemInEverySequenceOfFourInputsToo) {
  Walk walk{Interlock{kExpires}, {}};
  put_in(walk, In::key_on);
  put_in(walk, In::estop_off);
  put_in(walk, In::reset);
  put_in(walk, In::delay_passes);
  std::size_t sequences = 0;
  CHECK_EQUAL("", try_all(walk, 4, sequences).value_or(""));
  constexpr std::size_t n = kInputs;
  CHECK_EQUAL(1 + n + n * n + n * n * n + n * n * n * n, sequences);
}

// The judge knows the one right transition for every input, and the state after it: a table that it takes for
// good cannot be told from the shipped one by any sequence of inputs. Such are, of the cells' 360 wrong next
// states and 150 wrong answers, those that another barrier makes harmless: a latched stop or fault keeps its state
// whatever the cell says; expiry is put in only while armed; the trigger is asked for only in `firing`, where
// alone there is one left; CLEAR with nothing latched, where only its kind matters.
TEST(InterlockSpace, WouldNoticeAWrongCellOfTheTable) {
  Mutants states, answers;
  for (std::size_t input = 0; input < kInterlockEventCount; ++input) {
    for (std::size_t state = 0; state < kStateCount; ++state) {
      const Transition& good = kTransitionTable[input].in[state];
      TransitionTable table = kTransitionTable;
      for (std::size_t other = 0; other < kStateCount; ++other) {
        // What is refused changes no state.
        if (static_cast<State>(other) == good.next || good.kind == TransitionKind::refuse) continue;
        table[input].in[state] = {good.kind, static_cast<State>(other)};
        states.judge(table);
      }
      using enum TransitionKind;
      for (const TransitionKind other :
           is_asked(input) ? std::vector{grant, refuse} : std::vector{none, disarm, abort}) {
        if (other == good.kind) continue;
        table[input].in[state] = {other, good.next};
        answers.judge(table);
      }
    }
  }
  std::printf("interlock's cells: %d of %d wrong states and %d of %d wrong answers noticed\n", states.noticed,
              states.made, answers.noticed, answers.made);
  CHECK_EQUAL(231, states.noticed);
  CHECK_EQUAL(113, answers.noticed);
}

TEST(InterlockSpace, WouldNoticeAMissingGuard) {
  for (const std::uint32_t needed :
       {guard::named_host, guard::own_arming, guard::reset_by_host, guard::restart_delay})
    CHECK_TRUE(notices_without(InterlockEvent::arm, needed));
  for (const std::uint32_t needed : {guard::estop_off, guard::key_on, guard::after_stops})
    CHECK_TRUE(notices_without(InterlockEvent::reset, needed));
  for (const std::uint32_t needed : {guard::in_time, guard::token, guard::new_shot})
    CHECK_TRUE(notices_without(InterlockEvent::fire, needed));
  for (const std::uint32_t needed : {guard::this_shot, guard::trigger_pending})
    CHECK_TRUE(notices_without(InterlockEvent::trigger, needed));
  // A stop has already ended the arming, or cancelled the trigger: the second barrier behind the first.
  CHECK_FALSE(notices_without(InterlockEvent::arm, guard::permission));
  CHECK_FALSE(notices_without(InterlockEvent::fire, guard::permission));
  CHECK_FALSE(notices_without(InterlockEvent::trigger, guard::permission));
}

TEST(InterlockSpace, WouldNoticeAMissingAction) {
  Mutants mutants;
  for (std::size_t input = 0; input < kInterlockEventCount; ++input) {
    for (std::uint32_t bit = action::take_token; bit <= action::unlatch_stop; bit <<= 1) {
      TransitionTable table = kTransitionTable;
      if ((table[input].actions & bit) == 0) continue;
      table[input].actions &= ~bit;
      mutants.judge(table);
    }
  }
  // All but one: the trigger of a shot that is over is cancelled twice, by the state as well.
  CHECK_EQUAL(15, mutants.made);
  CHECK_EQUAL(14, mutants.noticed);
}

TEST(InterlockSpace, WithholdsTheTriggerByASecondBarrierIfStopsWereForgotten) {
  TransitionTable deaf = kTransitionTable;
  for (const InterlockEvent input :
       {InterlockEvent::key_off, InterlockEvent::key_on, InterlockEvent::estop_on, InterlockEvent::estop_off,
        InterlockEvent::disarm, InterlockEvent::suspended, InterlockEvent::fault})
    for (Transition& cell : deaf[static_cast<std::size_t>(input)].in) cell.kind = TransitionKind::none;
  CHECK_TRUE(search(deaf).complaint.find("withdrawn") != std::string::npos);
  // With every other complaint put aside, none is of the trigger: it asks for the permission itself.
  CHECK_EQUAL("", search(deaf, Severity::trigger_without_permission).complaint);
  deaf[static_cast<std::size_t>(InterlockEvent::trigger)].guards &= ~guard::permission;
  CHECK_TRUE(search(deaf, Severity::trigger_without_permission).complaint.find("PERMISSION") !=
             std::string::npos);
}
