// Random operators, hosts, lamps and freezes: whatever comes, the rig's limits hold. A failure prints the
// seed that repeats it (RC_PARAMS).
#include <rapidcheck.h>

#include "tests/support/sequencer_fixture.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;

namespace {

enum class Deed {
  arm,
  fire,
  fire_stale,
  fire_wrong,
  fire_dry,
  disarm,
  clear,
  key,
  estop,
  gate,
  sensor,
  freeze,
  count
};

struct Act {
  Deed deed;
  Duration after{};  ///< the one before
  Duration span{};   ///< of a freeze, or until key and e-stop are put back
};

rc::Gen<Act> act() {
  const auto deed = rc::gen::weightedElement<Deed>({{6, Deed::arm},
                                                    {6, Deed::fire},
                                                    {1, Deed::fire_stale},
                                                    {1, Deed::fire_wrong},
                                                    {1, Deed::fire_dry},
                                                    {1, Deed::disarm},
                                                    {1, Deed::clear},
                                                    {1, Deed::key},
                                                    {1, Deed::estop},
                                                    {1, Deed::gate},
                                                    {1, Deed::sensor},
                                                    {2, Deed::freeze}});
  return rc::gen::build<Act>(
      rc::gen::set(&Act::deed, deed),
      rc::gen::set(&Act::after, rc::gen::construct<Duration>(rc::gen::inRange<std::int64_t>(0, 400'000'000))),
      rc::gen::set(&Act::span,
                   rc::gen::construct<Duration>(rc::gen::inRange<std::int64_t>(1'000, 60'000'000))));
}

/// Levels of key and e-stop as they were driven, to be judged against the trigger's instants.
struct Driven {
  MonoTime time;
  Input input;
  bool active;
};

struct Story {
  SequencerFixture bench;
  std::vector<Driven> driven;
  std::vector<std::pair<MonoTime, Duration>> freezes;
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
  void perform(const Act& act) {
    VirtualRig& rig = bench.rig;
    run_until(rig.time + act.after);
    const std::int64_t token = rig.statuses.back().arm_token;
    switch (act.deed) {
      case Deed::arm:
        bench.give(bench.arm_command());
        break;
      case Deed::fire:
        fire(token, false);
        if (token != 0) stale_token = token;
        break;
      case Deed::fire_stale:
        fire(stale_token, false);
        break;
      case Deed::fire_wrong:
        fire(token + 1, false);
        break;
      case Deed::fire_dry:
        fire(token, true);
        break;
      case Deed::disarm:
        bench.give(bench.plain_command(CommandKind::disarm));
        break;
      case Deed::clear:
        bench.give(bench.plain_command(CommandKind::clear));
        break;
      case Deed::key:
      case Deed::estop: {
        const Input input = act.deed == Deed::key ? Input::key : Input::estop;
        drive(input, input == Input::estop, rig.time);
        drive(input, input == Input::key, rig.time + act.span);
        break;
      }
      case Deed::gate:
        rig.schedule({Input::gate, rig.time, true});
        break;
      case Deed::sensor:
        rig.schedule({Input::sensor_a, rig.time, true});
        break;
      case Deed::freeze:
        freezes.emplace_back(rig.time + act.span, act.span);
        rig.freeze(rig.time + act.span, act.span);
        break;
      case Deed::count:
        break;
    }
  }
  bool level_at(Input input, bool initially, MonoTime when) const {
    bool level = initially;
    for (const Driven& change : driven) {
      if (change.input == input && change.time <= when) level = change.active;
    }
    return level;
  }
  Duration frozen_between(MonoTime from, MonoTime to) const {
    Duration sum{};
    for (const auto& [when, span] : freezes) {
      if (when >= from - span && when <= to) sum = sum + span;
    }
    return sum;
  }
};

void check_on_times(const Story& story, Output output, Duration longest) {
  const auto on = story.bench.rig.instants(output), off = story.bench.rig.instants(output, false);
  RC_ASSERT(on.size() == off.size());
  for (std::size_t k = 0; k < on.size(); ++k) {
    // Two pulses of other outputs may be issued and spun for before this one's turn comes.
    const Duration slack = story.bench.config.lamps.max_on * 2 + story.frozen_between(on[k], off[k]);
    RC_ASSERT(off[k] - on[k] <= longest + slack);
  }
}

void check(const Story& story) {
  const VirtualRig& rig = story.bench.rig;
  const Rig& config = story.bench.config;
  RC_ASSERT(rig.all_inactive());
  std::size_t live_shots = 0;
  for (const ShotRecord* shot : rig.shots) {
    live_shots += shot->plan.dry ? 0 : 1;
    for (const FlashRecord& flash : shot->flashes) {
      if (!known(flash.issue_start)) continue;
      RC_ASSERT(flash.issue_start >= flash.commanded);
      const Duration late = flash.issue_start - flash.commanded;
      RC_ASSERT(late <=
                config.tolerance.abort_late + story.frozen_between(flash.commanded, flash.issue_start));
    }
  }
  const auto triggers = rig.instants(Output::trigger);
  RC_ASSERT(triggers.size() <= live_shots);
  for (const MonoTime trigger : triggers) {
    // A microsecond: from reading the lines to the call that sets the trigger. A freeze may fall just there.
    const MonoTime read =
        trigger - microseconds(1) - story.frozen_between(trigger - microseconds(1), trigger);
    RC_ASSERT(story.level_at(Input::key, true, trigger) || story.level_at(Input::key, true, read));
    RC_ASSERT(!story.level_at(Input::estop, false, trigger) || !story.level_at(Input::estop, false, read));
  }
  const auto flashes = rig.instants(Output::strobes);
  for (std::size_t k = 1; k < flashes.size(); ++k) {
    RC_ASSERT(flashes[k] - flashes[k - 1] >= config.lamps.min_period - config.tolerance.late);
  }
  check_on_times(story, Output::trigger, config.machine.max_on);
  check_on_times(story, Output::strobes, config.lamps.max_on);
  check_on_times(story, Output::shutter, config.shutter.max_open);
  RC_ASSERT(rig.count(EventKind::shot_started) ==
            rig.count(EventKind::shot_ended) + rig.count(EventKind::shot_aborted));
  RC_ASSERT(rig.count(EventKind::shot_started) == rig.shots.size());
}

}  // namespace

TEST_GROUP(SequencerProperty){};

TEST(SequencerProperty, HoldsTheRigsLimitsWhateverHappens) {
  const bool holds = rc::check("limits hold", [] {
    const auto acts = *rc::gen::container<std::vector<Act>>(20, act());
    Rig config = shipped_rig();
    config.plan.exposure = milliseconds(120);
    config.plan.impact_at = milliseconds(60);
    Story story{SequencerFixture(config), {}, {}, 1};
    story.bench.start();
    for (const Act& deed : acts) story.perform(deed);
    story.run_until(story.bench.rig.time + milliseconds(1500));
    check(story);
    RC_CLASSIFY(!story.bench.rig.instants(Output::trigger).empty(), "triggered");
    RC_CLASSIFY(story.bench.rig.count(EventKind::shot_aborted) > 0, "aborted");
  });
  CHECK_TRUE(holds);
}
