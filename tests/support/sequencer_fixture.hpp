// A sequencer on a virtual rig with one host that arms and fires, for tests.
#pragma once

#include <string>

#include "tests/support/virtual_rig.hpp"

namespace strobe::testing {

inline constexpr std::int64_t kHost = 77;

struct SequencerFixture {
  Rig config;
  VirtualRig rig;
  TimedOutputs outputs{config, rig, rig};
  Sequencer sequencer;
  std::int64_t last_command = 0, next_token = 500;

  using Prepare = void (*)(VirtualRig&);
  explicit SequencerFixture(
      const Rig& rig_config = shipped_rig(), const Tick& tick = {}, Prepare before_start = [](VirtualRig&) {})
      : config(rig_config),
        rig(static_cast<std::size_t>(rig_config.lamps.max_flashes)),
        sequencer(config, rig.ports(outputs), 0, tick) {
    before_start(rig);
    sequencer.start("test");
  }
  Command plain_command(CommandKind kind) {
    Command command;
    command.kind = kind;
    command.host_id = kHost;
    command.command_id = ++last_command;
    return command;
  }
  Command arm_command() {
    Command command = plain_command(CommandKind::arm);
    command.new_token = next_token++;
    return command;
  }
  Command fire_command(std::int64_t token) {
    Command command = plain_command(CommandKind::fire);
    command.token = token;
    command.plan = config.plan;
    return command;
  }

  /// As a person gives it just now.
  Command reset_command() {
    Command command = plain_command(CommandKind::reset);
    command.acted_boot_time = Duration{to_ns(rig.time)} + rig.asleep;
    return command;
  }

  bool step() { return sequencer.step(kNoDeadline); }
  void give(const Command& command) {
    rig.schedule_command(rig.time, command);
    step();
  }
  /// A person resets a stop, and waits until the rig may be armed again.
  void reset() {
    give(reset_command());
    for (const MonoTime end = rig.statuses.back().restart; rig.time < end;) step();
  }
  std::int64_t arm() {
    give(arm_command());
    return rig.statuses.back().arm_token;
  }
  /// Arms and fires; returns the shot's start. The shot is then still to be played.
  MonoTime fire(bool dry = false) {
    Command command = fire_command(arm());
    command.plan.dry = dry;
    give(command);
    return rig.find(EventKind::shot_started, rig.count(EventKind::shot_started) - 1)->device_time +
           ShotPlayer::kLead;
  }
  /// Turns until no shot is playing; at most ten seconds of the rig's time.
  void play() {
    const MonoTime end = rig.time + milliseconds(10'000);
    do {
      step();
    } while (sequencer.state() == State::firing && rig.time < end);
  }
  /// A whole shot; returns its start.
  MonoTime shoot(bool dry = false) {
    const MonoTime start = fire(dry);
    play();
    return start;
  }

  const ShotRecord& shot(std::size_t nth = 0) const { return *rig.shots.at(nth); }
  std::string abort_reason(std::size_t nth = 0) const { return std::string(shot(nth).abort_reason.view()); }
};

/// A fired shot's instants with the shipped numbers: the trigger is the first pulse, at the start.
inline constexpr Duration kShutterAt = milliseconds(310 - 250 - 45);
inline constexpr Duration kFirstFlashAt = milliseconds(310 - 250);

}  // namespace strobe::testing
