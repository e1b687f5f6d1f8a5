// Port: where the loop reports what happened. Everything is copied or handed over; no call waits.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/shot/shot_plan.hpp"
#include "common/units/time.hpp"
#include "firmware/ports/truncating_string.hpp"

namespace strobe::firmware {

/// Values are those of event_t.
enum class EventKind : std::int8_t {
  started = 1,
  stopped,
  armed,
  disarmed,
  refused,
  shot_started,
  shutter,
  trigger,
  flash,
  sensor,
  gate,
  key,
  estop,
  shot_ended,
  shot_aborted,
  fault,
  cleared,
  xsync,
  repaired,
  reset
};
enum class Line : std::int8_t {
  none = 0,
  strobe_a,
  strobe_b,
  shutter,
  trigger,
  sensor_a,
  sensor_b,
  gate,
  key,
  estop,
  xsync
};
inline constexpr std::size_t kLineCount = 11;  ///< with Line::none

struct Event {
  EventKind kind = EventKind::started;
  Line line = Line::none;
  std::int8_t level = -1;    ///< logical level after the change; -1: has no meaning
  std::int32_t shot_id = 0;  ///< 0: outside a shot
  std::int32_t flash_index = -1;
  MonoTime device_time;  ///< the kernel's stamp for inputs, issue_end for outputs
  MonoTime commanded = kNoTime;
  MonoTime issue_start = kNoTime;
  MonoTime issue_end = kNoTime;
  ShortText detail;
};

/// Values are those of status_t. Spent: the last shot was fired or aborted; only another can be armed.
/// Stopped: by key, e-stop, DISARM or sleep, until a person has it reset.
enum class State : std::int8_t { idle = 0, armed, firing, fault, spent, stopped };

/// The loop's state; reported at every change.
struct LoopStatus {
  State state = State::idle;
  bool key_active = false;
  bool estop_active = true;
  std::int64_t arm_host = 0;  ///< 0: not armed
  std::int64_t arm_token = 0;
  MonoTime arm_expires{};
  std::int32_t last_shot_id = 0;
  std::int64_t kernel_overflows = 0;
  std::string_view fault;  ///< the latched fault, a static text; empty: none
  std::string_view stop;   ///< the latched stop, likewise
  MonoTime restart{};      ///< nothing is armed before, as a stop was reset

  bool operator==(const LoopStatus&) const = default;
};

/// What the shutter's contact reported; values are those of shot_t.
enum class ShutterFeedback : std::int8_t { none = 0, seen, missing, late };

struct FlashRecord {
  Lamps lamps = Lamps::both;  ///< that were to flash
  MonoTime commanded;
  MonoTime issue_start = kNoTime;
  MonoTime issue_end = kNoTime;
  MonoTime observed_a = kNoTime;
  MonoTime observed_b = kNoTime;
  std::int32_t extra_edges = 0;
};

/// One shot as executed and observed. `flashes` has its capacity from the start, so that filling it never
/// allocates.
struct ShotRecord {
  std::int32_t shot_id = 0;
  std::int64_t host_id = 0;
  std::int64_t command_id = 0;  ///< of the FIRE: finds the notes that came with it
  ShotPlan plan;
  MonoTime start;
  MonoTime shutter_on = kNoTime;  ///< its line, issue_end
  MonoTime shutter_off = kNoTime;
  MonoTime shutter_open = kNoTime;  ///< by its contact, else line and lag
  MonoTime shutter_close = kNoTime;
  MonoTime trigger = kNoTime;
  MonoTime gate = kNoTime;
  ShutterFeedback shutter_feedback = ShutterFeedback::none;
  std::int64_t queue_overflows = 0;  ///< during the shot
  std::int64_t kernel_overflows = 0;
  ShortText abort_reason;  ///< empty: not aborted
  std::vector<FlashRecord> flashes;
};

/// All calls are real-time safe: no lock, no allocation, no wait.
class EventSink {
 public:
  virtual ~EventSink() = default;
  virtual void event(const Event& event) noexcept = 0;  ///< a full queue is counted, see overflows()
  virtual void status(const LoopStatus& status) noexcept = 0;
  virtual ShotRecord* free_record() noexcept = 0;           ///< nullptr if all are still being written
  virtual bool shot_done(ShotRecord* record) noexcept = 0;  ///< hands it over; false if there is no room yet
  virtual void flush() noexcept = 0;  ///< before sleeping: wakes the reader, if there is news
  virtual std::int64_t overflows() const noexcept = 0;  ///< events lost since the start
  virtual bool journal_ok() const noexcept = 0;
  virtual std::int32_t shot_id_limit() const noexcept = 0;  ///< the highest that a shot may have now
};

}  // namespace strobe::firmware
