// Plays one shot on the ports: has the outputs issue its pulses, assigns edges to flashes, adds the gate's
// burst, aborts. Real-time safe; one thread's. Driven by Sequencer.
#pragma once

#include "firmware/core/edge_assignment.hpp"
#include "firmware/core/interlock.hpp"
#include "firmware/core/pulse_schedule.hpp"
#include "firmware/core/tick.hpp"
#include "firmware/ports/clock.hpp"
#include "firmware/ports/command_source.hpp"
#include "firmware/ports/edge_source.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

class ShotPlayer final : private ScheduledOutputs::Listener {
 public:
  /// From FIRE to the schedule's first instant, at least: time for the event to be journalled.
  static constexpr Duration kLead = milliseconds(20);
  /// How long to wait for the sensors' last edges after the schedule's end.
  static constexpr Duration kEdgeTimeout = milliseconds(2);

  ShotPlayer(const Rig& rig, Clock& clock, EdgeSource& edges, EventSink& sink, Interlock& interlock,
             ScheduledOutputs& outputs, const Tick& tick);

  /// Requires: the interlock has granted the shot, and its plan has been checked.
  void begin(const Command& fire, std::int32_t shot_id, ShotRecord& record) noexcept;
  /// How long before a plan may be fired, so that the lamps have recharged when its first flash comes. Valid:
  /// not busy, the plan has been checked.
  Duration recharge_left(const ShotPlan& plan) noexcept;
  bool busy() const noexcept { return phase_ != Phase::idle; }
  std::int32_t shot_id() const noexcept { return busy() ? record_->shot_id : 0; }
  MonoTime next_due() const noexcept;    ///< kNoDeadline if there is nothing to do
  void edge(const Edge& edge) noexcept;  ///< of a sensor, the gate or the shutter's contact
  /// Ends the shot under way, if there is one: the interlock has ordered it, and withheld the trigger.
  void stop(const ShortText& why) noexcept;
  /// Likewise for a reason that the interlock does not know: it withholds the trigger from now on.
  /// late_for: when the pulse was due whose lateness it is.
  void abort(const ShortText& why, MonoTime late_for = kNoTime) noexcept;
  /// Issues what is due within the spin time, and ends the shot when it is over.
  void run_due() noexcept;

 private:
  enum class Phase { idle, playing, closing, handing_over };

  MonoTime at(Duration offset) const noexcept { return record_->start + offset; }
  bool allows(const PlannedPulse& pulse, MonoTime now) noexcept override;
  void switched_on(const PlannedPulse& pulse, const Issue& issue) noexcept override;
  void switched_off(Output output, const Issue& issue, Duration on_time) noexcept override;
  void failed(const ShortText& why, MonoTime late_for) noexcept override { abort(why, late_for); }
  const char* trigger_withheld() noexcept;
  Duration lead() const noexcept;
  void gate(MonoTime stamp) noexcept;
  void xsync(const Edge& edge) noexcept;
  void cut_short(const ShortText& why, MonoTime late_for) noexcept;
  void close() noexcept;
  ShutterFeedback shutter_feedback() const noexcept;
  bool lamps_recharged(const PlannedPulse& pulse, MonoTime now) noexcept;
  bool awaits_gate() const noexcept { return schedule_.gated && !known(record_->gate); }
  void end_if_over() noexcept;
  void report(EventKind kind, Line line, int level, const Issue& issue,
              std::int32_t flash_index = -1) noexcept;
  void report(EventKind kind, MonoTime time, const ShortText& detail, MonoTime commanded = kNoTime) noexcept;

  const Rig& rig_;
  Clock& clock_;
  EdgeSource& edges_;
  EventSink& sink_;
  Interlock& interlock_;
  ScheduledOutputs& outputs_;
  TickAvoidance tick_avoidance_;
  EdgeAssignment edge_assignment_;
  PulseSchedule schedule_;
  Phase phase_ = Phase::idle;
  ShotRecord* record_ = nullptr;
  MonoTime closes_at_;
  /// Of lamp A and of lamp B, of any shot. What they did before this start is not known: it may have been a
  /// flash just then.
  std::array<MonoTime, 2> last_flash_;
  bool shutter_seen_open_ = false;
  bool shutter_seen_closed_ = false;
  MonoTime gate_counts_from_ = kNoTime;  ///< kNoTime: not triggered yet
  std::int64_t overflows_before_ = 0;
  std::int64_t kernel_overflows_before_ = 0;
};

}  // namespace strobe::firmware
