#include "firmware/core/guarded_outputs.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

GuardedOutputs::GuardedOutputs(const Rig& rig, Clock& clock, OutputLines& lines)
    : clock_(clock), lines_(lines) {
  pulses_[index_of(Output::trigger)].longest = rig.machine.max_on;
  pulses_[index_of(Output::strobes)].longest = rig.lamps.max_on;
  pulses_[index_of(Output::shutter)].longest = rig.shutter.max_open;
}

Issue GuardedOutputs::activate(Output output, MonoTime commanded, Duration width, MonoTime now,
                               Lamps lamps) noexcept {
  Pulse& pulse = pulses_[index_of(output)];
  assert(width > Duration{} && pulse.longest > Duration{});
  Issue issue{commanded, now, {}, false};
  issue.done = output == Output::strobes ? lines_.set_lamps(lamps) : lines_.set(output, true);
  if (!issue.done) failed_ = true;
  issue.end = clock_.now();
  // Even a failed call may have driven the line: it is switched off like any other.
  pulse.active = true;
  pulse.since = issue.start;
  pulse.off_at = issue.end + std::min(width, pulse.longest);
  assert(pulse.off_at <= issue.end + pulse.longest);
  return issue;
}

Issue GuardedOutputs::deactivate(Output output, MonoTime now) noexcept {
  Pulse& pulse = pulses_[index_of(output)];
  Issue issue{pulse.off_at, now, {}, false};
  issue.done = lines_.set(output, false);
  issue.end = clock_.now();
  if (!issue.done) broken_ = failed_ = true;
  if (pulse.active) pulse.last_on_time = issue.end - pulse.since;
  pulse.active = false;
  return issue;
}

bool GuardedOutputs::all_off() noexcept {
  bool done = true;
  for (const Output output : kOutputs) done = deactivate(output, clock_.now()).done && done;
  assert(!any_active() && done == !broken_);
  return done;
}

bool GuardedOutputs::any_active() const noexcept {
  return std::any_of(pulses_.begin(), pulses_.end(), [](const Pulse& pulse) { return pulse.active; });
}

MonoTime GuardedOutputs::next_off() const noexcept {
  MonoTime next = kNoDeadline;
  for (const Pulse& pulse : pulses_) {
    if (pulse.active) next = std::min(next, pulse.off_at);
  }
  return next;
}

Output GuardedOutputs::next_off_output() const noexcept {
  assert(any_active());
  for (const Output output : kOutputs) {
    const Pulse& pulse = pulses_[index_of(output)];
    if (pulse.active && pulse.off_at == next_off()) return output;
  }
  return Output::trigger;
}

}  // namespace strobe::firmware
