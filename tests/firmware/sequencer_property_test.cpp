// Random operators, hosts, lamps and freezes: whatever comes, the rig's limits hold. A failure prints the
// seed that repeats it (RC_PARAMS).
#include <rapidcheck.h>

#include "tests/support/sequencer_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;

namespace {

enum class Action {
  arm,
  fire,
  fire_stale,
  fire_wrong,
  fire_dry,
  disarm,
  clear,
  reset,
  key,
  estop,
  gate,
  sensor,
  freeze
};

struct Step {
  Action action;
  Duration after{};  ///< the one before
  Duration span{};   ///< of a freeze, or until key and e-stop are put back
};

rc::Gen<Step> any_step() {
  const auto duration = [](std::int64_t least_ns, std::int64_t most_ns) {
    return rc::gen::construct<Duration>(rc::gen::inRange(least_ns, most_ns));
  };
  const auto rare = rc::gen::element(Action::fire_stale, Action::fire_wrong, Action::fire_dry, Action::disarm,
                                     Action::clear, Action::key, Action::estop, Action::gate, Action::sensor);
  const auto action = rc::gen::weightedOneOf<Action>({{6, rc::gen::just(Action::arm)},
                                                      {6, rc::gen::just(Action::fire)},
                                                      {3, rc::gen::just(Action::reset)},
                                                      {2, rc::gen::just(Action::freeze)},
                                                      {9, rare}});
  return rc::gen::build<Step>(rc::gen::set(&Step::action, action),
                              rc::gen::set(&Step::after, duration(0, 400'000'000)),
                              rc::gen::set(&Step::span, duration(1'000, 60'000'000)));
}

/// Levels of key and e-stop as they were driven, to be judged against the trigger's instants.
struct Driven {
  MonoTime time;
  Input input;
  bool active;
};

struct Run {
  SequencerFixture bench;
  std::vector<Driven> driven;
  std::vector<std::pair<MonoTime, Duration>> freezes;
  std::vector<MonoTime> stops, acts;
  std::int64_t stale_token = 1;

  void run_until(MonoTime end) {
    while (bench.rig.time < end) bench.sequencer.step(end);
  }
  void drive(Input input, bool active, MonoTime when) {
    driven.push_back({when, input, active});
    bench.rig.schedule({input, when, active});
  }
  void fire(std::int64_t token, bool dry) {
    Command command = bench.fire_command(token);
    command.plan.dry = dry;
    bench.give(command);
  }
  void perform(const Step& step) {
    VirtualRig& rig = bench.rig;
    run_until(rig.time + step.after);
    const std::int64_t token = rig.statuses.back().arm_token;
    switch (step.action) {
      case Action::arm:
        bench.give(bench.arm_command());
        break;
      case Action::fire:
        fire(token, false);
        if (token != 0) stale_token = token;
        break;
      case Action::fire_stale:
        fire(stale_token, false);
        break;
      case Action::fire_wrong:
        fire(token + 1, false);
        break;
      case Action::fire_dry:
        fire(token, true);
        break;
      case Action::disarm:
        stops.push_back(rig.time);
        bench.give(bench.plain_command(CommandKind::disarm));
        break;
      case Action::clear:
        bench.give(bench.plain_command(CommandKind::clear));
        break;
      case Action::reset:
        acts.push_back(rig.time);
        bench.give(bench.reset_command());
        break;
      case Action::key:
      case Action::estop: {
        const Input input = step.action == Action::key ? Input::key : Input::estop;
        drive(input, input == Input::estop, rig.time);
        drive(input, input == Input::key, rig.time + step.span);
        stops.push_back(rig.time);
        stops.push_back(rig.time + step.span);
        break;
      }
      case Action::gate:
        rig.schedule({Input::gate, rig.time, true});
        break;
      case Action::sensor:
        rig.schedule({Input::sensor_a, rig.time, true});
        break;
      case Action::freeze:
        freezes.emplace_back(rig.time + step.span, step.span);
        rig.freeze(rig.time + step.span, step.span);
        break;
    }
  }
  bool level_at(Input input, bool initially, MonoTime when) const {
    bool level = initially;
    for (const Driven& change : driven)
      if (change.input == input && change.time <= when) level = change.active;
    return level;
  }
  /// Whether a person has acted since the last stop, and the delay is over.
  bool acted_since_stops(MonoTime when) const {
    MonoTime stopped = kNoTime;
    for (const MonoTime stop : stops)
      if (stop < when - microseconds(2)) stopped = std::max(stopped, stop);
    return !known(stopped) || std::any_of(acts.begin(), acts.end(), [&](MonoTime act) {
      return act >= stopped && act + Interlock::kRestartDelay <= when;
    });
  }
  Duration frozen_between(MonoTime from, MonoTime to) const {
    Duration sum{};
    for (const auto& [when, span] : freezes)
      if (when >= from - span && when <= to) sum = sum + span;
    return sum;
  }
};

void check_on_times(const Run& run, Output output, Duration longest) {
  const auto on = run.bench.rig.instants(output), off = run.bench.rig.instants(output, false);
  RC_ASSERT(on.size() == off.size());
  for (std::size_t k = 0; k < on.size(); ++k) {
    // Two pulses of other outputs may be issued and spun for before this one's turn comes.
    const Duration slack = run.bench.config.lamps.max_on * 2 + run.frozen_between(on[k], off[k]);
    RC_ASSERT(off[k] - on[k] <= longest + slack);
  }
}

void check(const Run& run) {
  const VirtualRig& rig = run.bench.rig;
  const Rig& config = run.bench.config;
  RC_ASSERT(rig.all_inactive());
  std::size_t live_shots = 0;
  for (const ShotRecord* shot : rig.shots) {
    live_shots += shot->plan.dry ? 0 : 1;
    for (const FlashRecord& flash : shot->flashes) {
      if (!known(flash.issue_start)) continue;
      RC_ASSERT(flash.issue_start >= flash.commanded);
      const Duration late = flash.issue_start - flash.commanded;
      RC_ASSERT(late <= config.tolerance.abort_late + run.frozen_between(flash.commanded, flash.issue_start));
    }
  }
  const auto triggers = rig.instants(Output::trigger);
  RC_ASSERT(triggers.size() <= live_shots);
  for (const MonoTime trigger : triggers) {
    // A microsecond: from reading the lines to the call that sets the trigger. A freeze may fall just there.
    const MonoTime read = trigger - microseconds(1) - run.frozen_between(trigger - microseconds(1), trigger);
    RC_ASSERT(run.level_at(Input::key, true, trigger) || run.level_at(Input::key, true, read));
    RC_ASSERT(run.acted_since_stops(read));
    RC_ASSERT(!run.level_at(Input::estop, false, trigger) || !run.level_at(Input::estop, false, read));
  }
  const auto flashes = rig.instants(Output::strobes);
  for (std::size_t k = 1; k < flashes.size(); ++k)
    RC_ASSERT(flashes[k] - flashes[k - 1] >= config.lamps.min_period - config.tolerance.late);
  check_on_times(run, Output::trigger, config.machine.max_on);
  check_on_times(run, Output::strobes, config.lamps.max_on);
  check_on_times(run, Output::shutter, config.shutter.max_open);
  RC_ASSERT(rig.count(EventKind::shot_started) ==
            rig.count(EventKind::shot_ended) + rig.count(EventKind::shot_aborted));
  RC_ASSERT(rig.count(EventKind::shot_started) == rig.shots.size());
}

}  // namespace

TEST_GROUP(SequencerProperty){};

TEST(SequencerProperty, HoldsTheRigsLimitsWhateverHappens) {
  const bool holds = rc::check("limits hold", [] {
    const auto steps = *rc::gen::container<std::vector<Step>>(20, any_step());
    Rig config = shipped_rig();
    config.plan.exposure = milliseconds(120);
    config.plan.impact_at = milliseconds(60);
    Run run{SequencerFixture(config), {}, {}, {}, {}, 1};
    for (const Step& step : steps) run.perform(step);
    run.run_until(run.bench.rig.time + milliseconds(1500));
    check(run);
    RC_CLASSIFY(!run.bench.rig.instants(Output::trigger).empty(), "triggered");
    RC_CLASSIFY(run.bench.rig.count(EventKind::shot_aborted) > 0, "aborted");
  });
  CHECK_TRUE(holds);
}
