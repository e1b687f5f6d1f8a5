// Pulses timed by software: the loop spins to each instant and sets the lines. A pulse that would be later
// than the limit is not issued; there is no catching up.
#pragma once

#include "firmware/core/guarded_outputs.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

class TimedOutputs final : public ScheduledOutputs {
 public:
  /// Machines that suspend do so for longer.
  static constexpr Duration kAsleep = milliseconds(1);

  /// rig, clock and lines must outlive this.
  TimedOutputs(const Rig& rig, Clock& clock, OutputLines& lines);

  Duration lead(const PulseSchedule&) const noexcept override { return {}; }
  void begin(const PulseSchedule& schedule, MonoTime start, Listener& listener) noexcept override;
  void add(std::size_t) noexcept override {}
  void run(Listener& listener) noexcept override;
  MonoTime next_due() const noexcept override;
  bool all_issued() const noexcept override;
  bool cut() noexcept override;
  bool active(Output output) const noexcept override { return outputs_.active(output); }
  bool any_active() const noexcept override { return outputs_.any_active(); }
  bool broken() const noexcept override { return outputs_.broken(); }
  const char* take_failure() noexcept override {
    return outputs_.take_failure() ? "an output line could not be set" : nullptr;
  }

 private:
  MonoTime at(const PlannedPulse& pulse) const noexcept { return start_ + pulse.at; }
  void issue(const PlannedPulse& pulse, MonoTime now, Listener& listener) noexcept;
  void switch_off(Output output, MonoTime now, Listener& listener) noexcept;

  const Rig& rig_;
  Clock& clock_;
  GuardedOutputs outputs_;
  const PulseSchedule* schedule_ = nullptr;  ///< null: none, or cut
  MonoTime start_;
  std::size_t next_pulse_ = 0;
  Duration suspended_before_{};
};

}  // namespace strobe::firmware
