// The only access to the outputs: each is switched on only together with the instant at which it is switched
// off, no later than its longest on-time whatever the plan says. Real-time safe; one thread's.
#pragma once

#include <array>
#include <limits>
#include <utility>

#include "firmware/core/rig.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

class GuardedOutputs {
 public:
  GuardedOutputs(const Rig& rig, Clock& clock, OutputLines& lines);

  /// now: the clock's last reading, so that none comes between it and the call.
  /// lamps: of Output::strobes, which of them.
  Issue activate(Output output, MonoTime commanded, Duration width, MonoTime now,
                 Lamps lamps = Lamps::both) noexcept;
  Issue deactivate(Output output, MonoTime now) noexcept;
  /// Switches everything off now, the machine first. Returns false if a call failed: the lines may be active.
  bool all_off() noexcept;

  bool active(Output output) const noexcept { return pulses_[index_of(output)].active; }
  /// How long it was on before it was last switched off.
  Duration last_on_time(Output output) const noexcept { return pulses_[index_of(output)].last_on_time; }
  Duration max_on_time(Output output) const noexcept { return pulses_[index_of(output)].longest; }
  bool any_active() const noexcept;
  MonoTime next_off() const noexcept;               ///< kNoDeadline if all are inactive
  Output next_off_output() const noexcept;          ///< the output of next_off()
  bool broken() const noexcept { return broken_; }  ///< an output could not be switched off
  /// Whether a call failed since the last call of this.
  bool take_failure() noexcept { return std::exchange(failed_, false); }

 private:
  struct Pulse {
    bool active = false;
    MonoTime since;
    MonoTime off_at;
    Duration longest{};
    Duration last_on_time{};
  };
  Clock& clock_;
  OutputLines& lines_;
  std::array<Pulse, kOutputs.size()> pulses_;
  bool broken_ = false;
  bool failed_ = false;
};

}  // namespace strobe::firmware
