#include "firmware/core/timed_outputs.hpp"

#include <algorithm>
#include <cassert>

namespace strobe::firmware {

TimedOutputs::TimedOutputs(const Rig& rig, Clock& clock, OutputLines& lines)
    : rig_(rig), clock_(clock), outputs_(rig, clock, lines) {}

void TimedOutputs::begin(const PulseSchedule& schedule, MonoTime start, Listener&) noexcept {
  assert(!outputs_.any_active());
  schedule_ = &schedule;
  start_ = start;
  next_pulse_ = 0;
  suspended_before_ = clock_.suspended();
}

bool TimedOutputs::all_issued() const noexcept {
  return schedule_ == nullptr || next_pulse_ == schedule_->pulses.size();
}

MonoTime TimedOutputs::next_due() const noexcept {
  const MonoTime off = outputs_.next_off();
  return all_issued() ? off : std::min(off, at(schedule_->pulses[next_pulse_]));
}

void TimedOutputs::run(Listener& listener) noexcept {
  for (;;) {
    const MonoTime due = next_due();
    if (due == kNoDeadline || due > clock_.now() + rig_.tolerance.spin) return;
    const MonoTime now = clock_.spin_until(due);
    assert(now >= due);
    if (outputs_.next_off() <= due) {
      switch_off(outputs_.next_off_output(), now, listener);
    } else {
      issue(schedule_->pulses[next_pulse_++], now, listener);
    }
  }
}

void TimedOutputs::issue(const PlannedPulse& pulse, MonoTime now, Listener& listener) noexcept {
  // After hours of sleep nothing is late by this clock.
  if (clock_.suspended() - suspended_before_ > kAsleep)
    return listener.failed("the rig's computer was suspended", kNoTime);
  const Duration lateness = now - at(pulse);
  if (lateness > rig_.tolerance.abort_late) {
    ShortText why(pulse.output == Output::strobes   ? "flash "
                  : pulse.output == Output::trigger ? "trigger"
                                                    : "shutter");
    if (pulse.output == Output::strobes) why.append(pulse.flash_index);
    why.append(" would have been ").append(lateness / microseconds(1)).append(" us late");
    return listener.failed(why, at(pulse));
  }
  if (!listener.allows(pulse, now)) return;
  // Asking for the trigger takes time: two levels are read.
  const MonoTime begin = pulse.output == Output::trigger ? clock_.now() : now;
  const Issue issue = outputs_.activate(pulse.output, at(pulse), pulse.width, begin, pulse.lamps);
  listener.switched_on(pulse, issue);
}

void TimedOutputs::switch_off(Output output, MonoTime now, Listener& listener) noexcept {
  const Issue issue = outputs_.deactivate(output, now);
  listener.switched_off(output, issue, outputs_.last_on_time(output));
}

bool TimedOutputs::cut() noexcept {
  schedule_ = nullptr;
  return outputs_.all_off();
}

}  // namespace strobe::firmware
