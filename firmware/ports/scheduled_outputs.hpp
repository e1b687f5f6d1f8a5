// Port: plays the pulses of a shot. By software that waits for each instant and sets lines
// (core/timed_outputs.hpp), or by a flash sequencer that has the whole train and a clock of its own
// (flash_sequencer/). Whatever the plan says, no output is on for longer than the rig's longest on-time.
#pragma once

#include <cstdint>
#include <vector>

#include "common/shot/shot_plan.hpp"
#include "common/units/time.hpp"
#include "firmware/ports/output_lines.hpp"
#include "firmware/ports/truncating_string.hpp"

namespace strobe::firmware {

inline constexpr MonoTime kNoDeadline = MonoTime::max();

/// One pulse of an output. It ends `width` after it was issued, so that a late one is never cut short.
struct PlannedPulse {
  Duration at{};
  Output output = Output::strobes;
  Duration width{};
  std::int32_t flash_index = -1;  ///< strobes only
  Lamps lamps = Lamps::both;      ///< strobes only
};

/// Offsets are relative to the shot's start; the first is 0.
struct PulseSchedule {
  std::vector<PlannedPulse> pulses;  ///< sorted by `at`; capacity from reserve(), never exceeded
  std::vector<PlannedPulse> burst;   ///< gated: the flashes, offsets from the gate's edge; likewise
  Duration exposure_begin{};         ///< the shutter is open from here ...
  Duration exposure_end{};           ///< ... to here
  std::int32_t flash_count = 0;      ///< free: in `pulses`; gated: in `burst`
  Duration shortest_interval{};      ///< between two flashes
  bool gated = false;

  void reserve(std::int32_t max_flashes) {
    pulses.reserve(static_cast<std::size_t>(max_flashes) + 2);
    burst.reserve(static_cast<std::size_t>(max_flashes));
  }
};

/// An output that was set: the planned instant and the clock before and after.
struct Issue {
  MonoTime commanded;
  MonoTime start;
  MonoTime end;
  bool done = false;  ///< false: it failed
};

/// Real-time safe; one thread's.
class ScheduledOutputs {
 public:
  /// The shot's owner. Called from within begin(), add() and run() alone.
  class Listener {
   public:
    /// Whether the pulse may come at `now`: asked once, when it is about to be out of recall. Who says no has
    /// cut.
    virtual bool allows(const PlannedPulse& pulse, MonoTime now) noexcept = 0;
    virtual void switched_on(const PlannedPulse& pulse, const Issue& issue) noexcept = 0;
    virtual void switched_off(Output output, const Issue& issue, Duration on_time) noexcept = 0;
    /// The shot cannot go on. late_for: when the pulse was due whose lateness it is, or kNoTime.
    virtual void failed(const ShortText& why, MonoTime late_for) noexcept = 0;

   protected:
    ~Listener() = default;
  };

  virtual ~ScheduledOutputs() = default;
  /// How long before the schedule's first instant begin() must be called.
  virtual Duration lead(const PulseSchedule& schedule) const noexcept = 0;
  /// schedule: stays as it is until the shot is over, but for add().
  virtual void begin(const PulseSchedule& schedule, MonoTime start, Listener& listener) noexcept = 0;
  /// The gate's edge has come, and the burst is in `pulses` now, from its `first` on.
  virtual void add(std::size_t first) noexcept = 0;
  /// Tells what was issued and not yet told, if there is such; issues nothing.
  virtual void tell(Listener&) noexcept {}
  /// Issues what is due, and tells what was issued.
  virtual void run(Listener& listener) noexcept = 0;
  /// When run() has something to do next; kNoDeadline: not before something comes in, or never.
  virtual MonoTime next_due() const noexcept = 0;
  virtual bool all_issued() const noexcept = 0;  ///< and told: no pulse of the schedule is left
  /// Switches everything off now, the machine first, and drops what is left of the schedule. Returns false if
  /// that failed: the outputs may be active.
  virtual bool cut() noexcept = 0;
  virtual bool active(Output output) const noexcept = 0;  ///< or not yet known to be inactive
  virtual bool any_active() const noexcept {
    return active(Output::trigger) || active(Output::strobes) || active(Output::shutter);
  }
  virtual bool broken() const noexcept = 0;  ///< an output could not be switched off
  /// By what clock issues and stamps are, if it is not the rig's, and how well the two are known to each
  /// other.
  virtual ShortText clock_words() const noexcept { return {}; }
  /// What failed since the last call of this: a fault's words; null: nothing.
  virtual const char* take_failure() noexcept = 0;
};

}  // namespace strobe::firmware
