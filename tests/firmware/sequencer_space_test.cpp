// The shipped loop in every state that operators, hosts and time can bring it into: from each state that was
// found, by the shortest way there, every input once more, until no new state turns up. What the lines did is
// judged from outside: by who armed and fired what, and by when key and e-stop were turned.
#include <cstdio>
#include <deque>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/sequencer_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;

namespace {

constexpr std::int64_t kStranger = 99;
constexpr Duration kEStopLimit = milliseconds(1);

enum class In {
  arm,
  arm_by_stranger,
  fire,
  fire_dry,
  fire_again,  ///< with the token that was used last
  fire_by_stranger,
  disarm,
  clear,
  key_off,
  key_on,
  estop_on,
  estop_off,
  suspend,
  reset,         ///< a person acts now
  reset_before,  ///< a person acted just before the last stop
  inputs_fail,   ///< key and e-stop cannot be read
  inputs_work,
  set_fails,   ///< the next switching on
  to_trigger,  ///< time: until just after the machine's pulse begins
  to_flash,    ///< into the train
  to_spin,     ///< until less than a spin before the next flash
  to_end,      ///< until the shot is over
  to_expiry,
  to_restart,  ///< until the delay after a reset is over
  count
};
constexpr int kInputs = static_cast<int>(In::count);

Rig short_shots() {
  Rig rig = shipped_rig();
  rig.machine.lag = milliseconds(30);
  rig.shutter.lag = milliseconds(5);
  rig.machine.pulse = milliseconds(4);
  rig.plan.exposure = milliseconds(24);
  rig.plan.impact_at = milliseconds(12);
  rig.arming_expires = milliseconds(2'000);
  return rig;
}

struct Press {
  MonoTime pressed, released;
};

/// One sequence of inputs, and what an observer knows of it.
class History {
 public:
  explicit History(const Rig& config) : bench_(config) {}

  void put_in(In input) {
    VirtualRig& rig = bench_.rig;
    switch (input) {
      case In::arm:
        return arm(kHost);
      case In::arm_by_stranger:
        return arm(kStranger);
      case In::fire:
        return fire(holder(), token(), false);
      case In::fire_dry:
        return fire(holder(), token(), true);
      case In::fire_again:
        return fire(kHost, used_token_, false);
      case In::fire_by_stranger:
        return fire(holder() == kStranger ? kHost : kStranger, token(), false);
      case In::disarm:
        stop();
        return bench_.give(bench_.plain_command(CommandKind::disarm));
      case In::suspend:
        stop();
        rig.asleep = rig.asleep + milliseconds(1'000);
        return run_for(microseconds(1));
      case In::reset:
        return reset(Duration{to_ns(rig.time)} + rig.asleep);
      case In::reset_before:
        return reset(last_stop_);
      case In::clear:
        if (bench_.rig.levels_readable && bench_.sequencer.state() != State::firing) faulted_ = false;
        return bench_.give(bench_.plain_command(CommandKind::clear));
      case In::key_off:
      case In::key_on:
        return turn(Input::key, input == In::key_on);
      case In::estop_on:
      case In::estop_off:
        return turn(Input::estop, input == In::estop_on);
      case In::inputs_fail:
      case In::inputs_work:
        rig.levels_readable = input == In::inputs_work;
        faulted_ = faulted_ || input == In::inputs_fail;
        return run_for(Sequencer::kLongestSleep * 2);
      case In::set_fails:
        rig.set_succeeds = [armed = true](Output, bool active) mutable {
          return !(active && std::exchange(armed, false));
        };
        return;
      case In::to_trigger:
        return run_until_active(Output::trigger);
      case In::to_flash:
        return run_until_active(Output::strobes);
      case In::to_spin:
        // Past the pulse; the last 200 us before the next flash are spun.
        run_until_active(Output::strobes);
        if (rig.level_of(Output::strobes)) run_for(bench_.config.plan.period - microseconds(100));
        return;
      case In::to_end:
        return bench_.play();
      case In::to_expiry:
        return run_for(bench_.config.arming_expires + Sequencer::kLongestSleep);
      case In::to_restart:
        return run_for(Interlock::kRestartDelay);
      case In::count:
        break;
    }
  }

  /// What future answers depend on, and what the observer knows.
  using Key = std::tuple<int, bool, bool, bool, bool, std::int64_t, bool, bool, bool, bool, bool, bool, bool,
                         bool, bool, bool, bool>;
  Key key() const {
    const LoopStatus& status = bench_.rig.statuses.back();
    const bool firing = bench_.sequencer.state() == State::firing;
    return {static_cast<int>(bench_.sequencer.state()),
            bench_.rig.key,
            bench_.rig.estop,
            !status.fault.empty(),
            faulted_,
            status.arm_host,
            bench_.rig.levels_readable,
            firing && aborts() > aborts_at_fire_,
            firing && last_dry_,
            firing && bench_.rig.instants(Output::trigger).size() > triggers_at_fire_,
            firing && bench_.rig.instants(Output::strobes).size() > flashes_at_fire_,
            bench_.rig.level_of(Output::shutter),
            bench_.rig.time < status.arm_expires,
            used_token_ != 0,
            stopped_,
            stops_.empty(),
            bench_.rig.time < status.restart};
  }

  /// "" or what went against the rules, once everything has come to rest.
  std::string verdict() {
    bench_.play();
    run_for(milliseconds(100));
    const VirtualRig& rig = bench_.rig;
    if (!rig.all_inactive()) return "an output is active at rest";
    std::string wrong = judge_triggers() + withheld_;
    for (const Press& press : presses_) {
      for (const auto& set : rig.sets) {
        if (set.active && set.time >= press.pressed + kEStopLimit && set.time < press.released)
          wrong += "; active after the e-stop";
        if (!set.active && set.time >= press.pressed + kEStopLimit && set.time < press.released &&
            was_active_before(set))
          wrong += "; inactive only late after the e-stop";
      }
    }
    for (const ShotRecord* shot : rig.shots)
      if (!shot_ids_.insert(shot->shot_id).second) wrong += "; a shot was fired twice";
    if (rig.count(EventKind::shot_started) != rig.shots.size()) wrong += "; a shot without a record";
    return wrong + on_times();
  }
  std::size_t triggers() const { return bench_.rig.instants(Output::trigger).size(); }
  std::size_t presses() const { return presses_.size(); }

 private:
  struct Granted {
    MonoTime from;
    bool live;
  };

  std::int64_t token() const { return bench_.rig.statuses.back().arm_token; }
  std::int64_t holder() const {
    const std::int64_t host = bench_.rig.statuses.back().arm_host;
    return host == 0 ? kHost : host;
  }
  std::size_t aborts() const { return bench_.rig.count(EventKind::shot_aborted); }
  bool permitted() const {
    return bench_.rig.key && !bench_.rig.estop && bench_.rig.levels_readable &&
           bench_.rig.statuses.back().fault.empty() && !faulted_ && !stopped_;
  }

  void arm(std::int64_t host) {
    Command command = bench_.arm_command();
    command.host_id = host;
    bench_.give(command);
  }
  void fire(std::int64_t host, std::int64_t token_sent, bool dry) {
    Command command = bench_.fire_command(token_sent);
    command.host_id = host;
    command.plan.dry = dry;
    // Judged before the firmware is asked: only then is it independent of its answer.
    const bool right = permitted() && token_sent != 0 && token_sent != used_token_ && token_sent == token() &&
                       host == bench_.rig.statuses.back().arm_host &&
                       bench_.rig.time < bench_.rig.statuses.back().arm_expires;
    const std::size_t triggers = bench_.rig.instants(Output::trigger).size();
    const std::size_t flashes = bench_.rig.instants(Output::strobes).size();
    const std::size_t aborted = aborts();
    if (right) granted_.push_back({bench_.rig.time, !dry});
    bench_.give(command);
    if (right && bench_.sequencer.state() != State::firing) withheld_ = "; a shot of good right was refused";
    if (!right) return;
    used_token_ = token_sent;
    triggers_at_fire_ = triggers;
    flashes_at_fire_ = flashes;
    aborts_at_fire_ = aborted;
    last_dry_ = dry;
  }
  void turn(Input input, bool active) {
    VirtualRig& rig = bench_.rig;
    const bool was = input == Input::key ? rig.key : rig.estop;
    if (was == active) return;
    if (input == Input::estop && active) presses_.push_back({rig.time, kNoDeadline});
    if (input == Input::estop && !active && !presses_.empty()) presses_.back().released = rig.time;
    if (input == Input::key) keys_.push_back({rig.time, active});
    stop();
    rig.schedule({input, rig.time, active});
    bench_.step();
  }
  void stop() {
    stopped_ = true;
    stops_.push_back(bench_.rig.time);
    last_stop_ = Duration{to_ns(bench_.rig.time)} + bench_.rig.asleep;
  }
  void reset(Duration acted) {
    Command command = bench_.reset_command();
    command.acted_boot_time = acted;
    const bool right = bench_.rig.key && !bench_.rig.estop && bench_.rig.levels_readable &&
                       acted > last_stop_ && bench_.sequencer.state() != State::firing;
    if (right) {
      if (stopped_) resets_.push_back(bench_.rig.time);
      stopped_ = false;
    }
    bench_.give(command);
  }
  void run_for(Duration time) {
    const MonoTime end = bench_.rig.time + time;
    while (bench_.rig.time < end) bench_.sequencer.step(end);
  }
  void run_until_active(Output output) {
    const std::size_t before = bench_.rig.instants(output).size();
    const MonoTime end = bench_.rig.time + milliseconds(100);
    while (bench_.rig.time < end && bench_.rig.instants(output).size() == before &&
           bench_.sequencer.state() == State::firing)
      bench_.sequencer.step(end);
  }
  bool was_active_before(const VirtualRig::Set& off) const {
    bool level = false;
    for (const auto& set : bench_.rig.sets) {
      if (&set == &off) return level;
      if (set.output == off.output) level = set.active;
    }
    return false;
  }
  bool key_on_at(MonoTime when) const {
    bool on = true;
    for (const auto& [time, active] : keys_)
      if (time <= when) on = active;
    return on;
  }
  std::string judge_triggers() const {
    std::size_t live = 0;
    for (const Granted& grant : granted_) live += grant.live ? 1 : 0;
    const auto triggers = bench_.rig.instants(Output::trigger);
    if (triggers.size() > live) return "; MORE TRIGGERS THAN LIVE SHOTS";
    for (const MonoTime trigger : triggers) {
      const Granted* last = nullptr;
      for (const Granted& grant : granted_)
        if (grant.from <= trigger) last = &grant;
      if (last == nullptr || !last->live) return "; A TRIGGER WITHOUT A SHOT";
      if (!allowed_by_stops(trigger)) return "; A TRIGGER AFTER A STOP THAT NOBODY HAS RESET";
      if (!key_on_at(trigger)) return "; A TRIGGER WITH THE KEY OFF";
      for (const Press& press : presses_)
        if (trigger > press.pressed && trigger < press.released) return "; A TRIGGER WITH THE E-STOP PRESSED";
    }
    return "";
  }
  /// Between a stop and a trigger there is a person's act, and the delay after it.
  bool allowed_by_stops(MonoTime trigger) const {
    MonoTime stopped = kNoTime, reset = kNoTime;
    for (const MonoTime stop : stops_)
      if (stop < trigger) stopped = stop;
    if (!known(stopped)) return true;
    for (const MonoTime done : resets_)
      if (done < trigger) reset = done;
    return known(reset) && reset >= stopped && trigger - reset >= Interlock::kRestartDelay;
  }
  std::string on_times() const {
    std::string wrong;
    for (const Output output : kOutputs) {
      const auto on = bench_.rig.instants(output), off = bench_.rig.instants(output, false);
      const Duration longest = output == Output::trigger   ? bench_.config.machine.max_on
                               : output == Output::strobes ? bench_.config.lamps.max_on
                                                           : bench_.config.shutter.max_open;
      if (on.size() != off.size()) return "; an output stays on";
      for (std::size_t k = 0; k < on.size(); ++k)
        if (off[k] - on[k] > longest + microseconds(2)) wrong = "; on for too long";
    }
    return wrong;
  }

  SequencerFixture bench_;
  std::int64_t used_token_ = 0;
  std::vector<Granted> granted_;
  std::vector<Press> presses_;
  std::vector<std::pair<MonoTime, bool>> keys_;
  std::set<std::int32_t> shot_ids_;
  std::size_t triggers_at_fire_ = 0, flashes_at_fire_ = 0, aborts_at_fire_ = 0;
  bool last_dry_ = false;
  bool stopped_ = false;  ///< and no person has acted since
  std::vector<MonoTime> stops_, resets_;
  Duration last_stop_{};
  bool faulted_ = false;  ///< the inputs failed, and nobody has cleared that since they work again
  std::string withheld_;
};

std::string path_text(const std::vector<In>& path) {
  std::string text = " after";
  for (const In input : path) text += " " + std::to_string(static_cast<int>(input));
  return text;
}

}  // namespace

TEST_GROUP(SequencerSpace){};

TEST(SequencerSpace, KeepsTheRulesFromEveryStateWithEveryInput) {
  const Rig config = short_shots();
  std::set<History::Key> known;
  std::deque<std::vector<In>> open{{}};
  known.insert(History(config).key());
  std::size_t states = 0, histories = 0, fired = 0, stopped = 0, depth = 0;
  while (!open.empty()) {
    const std::vector<In> path = open.front();
    open.pop_front();
    ++states;
    depth = path.size();
    for (int i = 0; i < kInputs; ++i) {
      std::vector<In> longer = path;
      longer.push_back(static_cast<In>(i));
      History history(config);
      for (const In input : longer) history.put_in(input);
      if (known.insert(history.key()).second) open.push_back(longer);
      const std::string wrong = history.verdict();
      if (!wrong.empty()) FAIL((wrong + path_text(longer)).c_str());
      ++histories;
      fired += history.triggers() > 0 ? 1 : 0;
      stopped += history.presses() > 0 ? 1 : 0;
    }
  }
  std::printf(
      "sequencer: %zu states, %zu histories (%zu with a trigger, %zu with an e-stop), longest way %zu\n",
      states, histories, fired, stopped, depth);
  CHECK(fired > 100);
  CHECK(stopped > 100);
}
