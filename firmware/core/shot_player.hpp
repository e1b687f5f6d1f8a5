// Plays one shot on the ports: pulses at their instants, flashes entered in the book, the gate's burst, the
// abort. A pulse that is late beyond the limit is not issued at all: the shot is aborted, never caught up
// with. Real-time safe; one thread's. Driven by Sequencer.
#pragma once

#include "firmware/core/edge_assignment.hpp"
#include "firmware/core/guarded_outputs.hpp"
#include "firmware/core/interlock.hpp"
#include "firmware/core/shot_plan.hpp"
#include "firmware/core/tick_avoidance.hpp"
#include "firmware/ports/command_source.hpp"
#include "firmware/ports/edge_source.hpp"

namespace strobe::firmware {

class ShotPlayer {
 public:
  /// From FIRE to the plan's first instant: room for the loop to come round and for the event to be
  /// journalled.
  static constexpr Duration kLead = milliseconds(20);
  /// After the plan's end the sensors' last edges are waited for.
  static constexpr Duration kEdgeTimeout = milliseconds(2);

  ShotPlayer(const Rig& rig, Clock& clock, EdgeSource& edges, EventSink& sink, Interlock& interlock,
             GuardedOutputs& outputs);

  /// The interlock has granted it; the plan has been checked.
  void begin(const Command& fire, std::int32_t shot_id, ShotRecord& record) noexcept;
  bool busy() const noexcept { return phase_ != Phase::idle; }
  std::int32_t shot_id() const noexcept { return busy() ? record_->shot_id : 0; }
  MonoTime next_due() const noexcept;    ///< kNoDeadline: nothing to do
  void edge(const Edge& edge) noexcept;  ///< of a sensor, the gate or the shutter's contact
  void abort(const ShortText& why) noexcept;
  /// Issues what is due within the spinning stretch, and ends the shot when its time has come.
  void run_due() noexcept;

 private:
  enum class Phase { idle, playing, closing, handing_over };

  MonoTime at(Duration offset) const noexcept { return record_->start + offset; }
  MonoTime next_issue() const noexcept;
  void issue_next(MonoTime due, MonoTime now) noexcept;
  void issue(const PlannedPulse& pulse, MonoTime now) noexcept;
  void flash(const PlannedPulse& pulse, MonoTime now) noexcept;
  void trigger(const PlannedPulse& pulse) noexcept;
  void shutter(const PlannedPulse& pulse, MonoTime now) noexcept;
  void switch_off(Output output, MonoTime now) noexcept;
  void gate(MonoTime stamp) noexcept;
  void xsync(const Edge& edge) noexcept;
  void close() noexcept;
  ShutterFeedback shutter_feedback() const noexcept;
  bool lamps_recharged(const PlannedPulse& pulse, MonoTime now) noexcept;
  bool awaits_gate() const noexcept { return plan_.gated && !known(record_->gate); }
  void end_if_over() noexcept;
  void report(EventKind kind, Line line, int level, const Issue& issue,
              std::int32_t flash_index = -1) noexcept;
  void report(EventKind kind, MonoTime time, const ShortText& detail) noexcept;

  const Rig& rig_;
  Clock& clock_;
  EdgeSource& edges_;
  EventSink& sink_;
  Interlock& interlock_;
  GuardedOutputs& outputs_;
  TickAvoidance tick_avoidance_;
  EdgeAssignment edge_assignment_;
  ShotPlan plan_;
  std::size_t next_pulse_ = 0;
  Phase phase_ = Phase::idle;
  ShotRecord* record_ = nullptr;
  MonoTime closes_at_;
  std::array<MonoTime, 2> last_flash_;  ///< of lamp A and of lamp B
  bool shutter_seen_open_ = false;
  bool shutter_seen_closed_ = false;
  MonoTime gate_counts_from_ = kNoTime;  ///< never: the machine was not yet triggered
  std::int64_t overflows_before_ = 0;
  std::int64_t kernel_overflows_before_ = 0;
};

}  // namespace strobe::firmware
