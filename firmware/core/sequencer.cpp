#include "firmware/core/sequencer.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

Sequencer::Sequencer(const Rig& rig, const Ports& ports, std::int32_t last_shot_id, const Tick& tick)
    : rig_(rig),
      clock_(ports.clock),
      edges_(ports.edges),
      sink_(ports.sink),
      commands_(ports.commands),
      interlock_(rig.arming_expires, last_shot_id),
      outputs_(ports.outputs),
      player_(rig_, ports.clock, ports.edges, ports.sink, interlock_, outputs_, tick),
      awake_(rig.tolerance),
      woken_(ports.clock.now()),
      suspended_(ports.clock.suspended()) {}

void Sequencer::report(EventKind kind, const ShortText& detail) noexcept {
  Event event;
  event.kind = kind;
  event.shot_id = player_.shot_id();
  event.device_time = clock_.now();
  event.detail = detail;
  sink_.event(event);
}

void Sequencer::refuse(const Command& command, std::string_view why) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"", "ARM", "FIRE", "DISARM", "RESEND", "CLEAR", "RESET"};
  ShortText words(kNames[static_cast<std::size_t>(command.kind)]);
  report(EventKind::refused, words.append(": ").append(why));
}

bool Sequencer::start(const ShortText& detail) noexcept {
  const bool safe = outputs_.cut();
  report(EventKind::started, detail);
  start_interlock();
  read_levels();
  report_status();
  sink_.flush();
  return safe;
}

/// What is pressed or off now has to be reset by a person; what is well from the start has not.
void Sequencer::start_interlock() noexcept {
  const auto key = edges_.level(Input::key);
  const auto estop = edges_.level(Input::estop);
  interlock_.start(key.value_or(false), estop.value_or(true));
  const MonoTime now = clock_.now();
  if (!interlock_.estop_active()) report_level(Input::estop, false, now);
  if (interlock_.key_active()) report_level(Input::key, true, now);
}

void Sequencer::apply(Interlock::Effect effect) noexcept {
  using Kind = Interlock::Effect::Kind;
  if (effect.kind == Kind::abort) player_.stop(effect.why);
  if (effect.kind == Kind::disarmed) report(EventKind::disarmed, effect.why);
}

void Sequencer::fault(const char* why) noexcept {
  const bool news = interlock_.fault_text()[0] == '\0';
  apply(interlock_.fault(why));
  if (news) report(EventKind::fault, why);
}

void Sequencer::lines_fail(const char* why) noexcept {
  fault(why);
  // Tells whether the chip is there at all: outputs that cannot be set are the guardian's.
  outputs_.cut();
}

void Sequencer::level(Input input, bool active, MonoTime stamp) noexcept {
  const bool is_key = input == Input::key;
  if ((is_key ? interlock_.key_active() : interlock_.estop_active()) == active) return;
  // First what makes safe, then what tells of it.
  const MonoTime now = clock_.now();
  apply(is_key ? interlock_.key(active, now) : interlock_.estop(active, now));
  report_level(input, active, stamp);
}

void Sequencer::report_level(Input input, bool active, MonoTime stamp) noexcept {
  Event event;
  event.kind = input == Input::key ? EventKind::key : EventKind::estop;
  event.line = input == Input::key ? Line::key : Line::estop;
  event.level = active ? 1 : 0;
  event.shot_id = player_.shot_id();
  event.device_time = stamp;
  sink_.event(event);
}

/// False, and a fault: one of them cannot be read.
bool Sequencer::read_levels() noexcept {
  const auto key = edges_.level(Input::key);
  const auto estop = edges_.level(Input::estop);
  levels_read_ = clock_.now();
  if (!key || !estop) {
    lines_fail("key or e-stop cannot be read");
    return false;
  }
  level(Input::estop, *estop, levels_read_);
  level(Input::key, *key, levels_read_);
  return true;
}

/// Why the next shot could not be recorded; null if it could.
const char* Sequencer::unready() const noexcept {
  if (!sink_.journal_ok()) return "the journal cannot be written";
  if (interlock_.shot_id() >= sink_.shot_id_limit()) return "no number is set aside for the shot yet";
  return nullptr;
}

namespace {

/// Who asks, for a person.
ShortText host_of(const Command& command) {
  ShortText host;
  host.append(command.host_id, 16);
  if (!command.host_name.empty()) host.append(" ").append(command.host_name.view());
  return host;
}

}  // namespace

void Sequencer::arm(const Command& command) noexcept {
  if (const char* why = unready()) return refuse(command, why);
  read_levels();
  if (const char* why = interlock_.arm(command.host_id, command.new_token, clock_.now())) {
    return refuse(command, why);
  }
  report(EventKind::armed, host_of(command));
}

/// Each is confirmed by an event of its own, also where nothing was armed: from now on nothing is, until a
/// person acts.
void Sequencer::disarm(const Command& command) noexcept {
  const Interlock::Effect effect = interlock_.disarm(clock_.now());
  if (effect.kind == Interlock::Effect::Kind::abort) apply(effect);
  ShortText words("disarmed by command ");
  report(EventKind::disarmed,
         words.append(command.command_id).append(" of ").append(host_of(command).view()));
}

void Sequencer::reset(const Command& command) noexcept {
  if (!read_levels()) return refuse(command, "key or e-stop cannot be read");
  const bool news = interlock_.stop_text()[0] != '\0' || !interlock_.admitted(command.host_id);
  const MonoTime acted = from_ns((command.acted_boot_time - clock_.suspended()).count());
  if (const char* why = interlock_.reset(command.host_id, acted, clock_.now())) return refuse(command, why);
  if (news) report(EventKind::reset, host_of(command));
}

namespace {

/// What an armed rig needs (SAFETY.md).
bool may_be_armed(const Interlock& interlock) {
  const bool at_rest = interlock.fault_text()[0] == '\0' && interlock.stop_text()[0] == '\0';
  return at_rest && interlock.key_active() && !interlock.estop_active() && interlock.arm_host() != 0;
}

}  // namespace

void Sequencer::clear(const Command& command) noexcept {
  if (const char* why = interlock_.clear()) return refuse(command, why);
  report(EventKind::cleared, "");
  read_levels();  // latches anew if the cause is still there
}

void Sequencer::fire(const Command& command) noexcept {
  if (const char* why = unready()) return refuse(command, why);
  ShotRecord* record = sink_.free_record();
  if (record == nullptr) return refuse(command, "earlier shots are still being written");
  // Before the machine's trigger: a ball without a flash is none for the reduction.
  if (const Duration left = player_.busy() ? Duration{} : player_.recharge_left(command.plan);
      left > Duration{}) {
    ShortText why("the lamps have not recharged: again in ");
    return refuse(command, why.append((left + milliseconds(1)) / milliseconds(1)).append(" ms").view());
  }
  read_levels();
  const std::int32_t shot_id = interlock_.shot_id() + 1;
  if (const char* why =
          interlock_.fire(command.host_id, command.token, shot_id, command.plan.dry, clock_.now())) {
    return refuse(command, why);
  }
  player_.begin(command, shot_id, *record);
}

void Sequencer::dispatch(const Command& command) noexcept {
  // Who has the lab's key may stop it, whatever else is wrong with the command.
  const bool stops = command.kind == CommandKind::disarm;
  if (!command.defect.empty() && !stops) return refuse(command, command.defect.view());
  switch (command.kind) {
    case CommandKind::arm:
      return arm(command);
    case CommandKind::fire:
      return fire(command);
    case CommandKind::disarm:
      return disarm(command);
    case CommandKind::clear:
      return clear(command);
    case CommandKind::reset:
      return reset(command);
    case CommandKind::resend:
      return refuse(command, "not for the loop");
  }
}

std::optional<std::size_t> Sequencer::wait(MonoTime latest) noexcept {
  const MonoTime begin = clock_.now();
  const MonoTime due = player_.next_due();
  const MonoTime wake = due == kNoDeadline ? due : awake_.wake_time(due);
  awake_.note(begin, begin - woken_);
  const bool sleeps = wake > begin;
  const auto count =
      sleeps ? edges_.wait(std::min({wake, begin + kLongestSleep, latest}), edge_buffer_)
             : edges_.poll(std::min({due - rig_.tolerance.spin, begin + kLongestPoll, latest}), edge_buffer_);
  woken_ = clock_.now();
  awake_.note(woken_, sleeps ? Duration{} : woken_ - begin);
  return count;
}

/// What this clock does not show, or shows too late. turned: when the turn before came this far.
void Sequencer::check_time(MonoTime turned) noexcept {
  if (const Duration suspended = clock_.suspended(); suspended - suspended_ > TimedOutputs::kAsleep) {
    suspended_ = suspended;
    const Interlock::Effect effect = interlock_.suspended(clock_.now());
    apply(effect);
    if (effect.kind == Interlock::Effect::Kind::none)
      report(EventKind::disarmed, "the rig's computer was suspended");
  }
  if (woken_ - turned > kStoodStill) apply(interlock_.stood_still());
}

bool Sequencer::step(MonoTime latest) noexcept {
  sink_.flush();
  const MonoTime turned = woken_;
  const auto count = wait(latest);
  check_time(turned);
  if (!count) lines_fail("the inputs' edges cannot be read");
  for (std::size_t i = 0; i < count.value_or(0); ++i) {
    const Edge& edge = edge_buffer_[i];
    if (edge.input == Input::key || edge.input == Input::estop) {
      level(edge.input, edge.active, edge.time);
    } else {
      player_.edge(edge);
    }
  }
  Command command;
  while (commands_.pop(command)) dispatch(command);
  if (clock_.now() - levels_read_ >= kLongestSleep) read_levels();
  apply(interlock_.tick(clock_.now()));
  player_.run_due();
  if (const char* failure = outputs_.take_failure()) fault(failure);
  report_status();
  assert((interlock_.state() == State::firing) == player_.busy());
  assert(player_.busy() || !outputs_.any_active() || outputs_.broken());
  assert(player_.busy() || !interlock_.trigger_pending());
  assert(interlock_.state() != State::armed || may_be_armed(interlock_));
  return !outputs_.broken();
}

bool Sequencer::stop(const ShortText& why) noexcept {
  player_.abort(why);
  const bool cut = outputs_.cut();
  for (int turn = 0; turn < 1000 && player_.busy(); ++turn) {
    edges_.wait(std::min(player_.next_due(), clock_.now() + milliseconds(1)), edge_buffer_);
    player_.run_due();
  }
  const bool safe = cut && !outputs_.broken() && !outputs_.any_active();
  report(EventKind::stopped, why);
  report_status();
  sink_.flush();
  return safe;
}

void Sequencer::report_status() noexcept {
  LoopStatus status;
  status.state = interlock_.state();
  status.key_active = interlock_.key_active();
  status.estop_active = interlock_.estop_active();
  status.arm_host = interlock_.arm_host();
  status.arm_token = interlock_.arm_token();
  status.arm_expires = interlock_.arm_expires();
  status.last_shot_id = interlock_.shot_id();
  status.kernel_overflows = edges_.kernel_overflows();
  status.fault = interlock_.fault_text();
  status.stop = interlock_.stop_text();
  status.restart = interlock_.restart();
  if (reported_ == status) return;
  reported_ = status;
  sink_.status(status);
}

}  // namespace strobe::firmware
