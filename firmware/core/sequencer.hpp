// The real-time loop, one turn at a time: wait for the next instant, an edge or a command; apply the
// interlock; play the shot. Runs on the ports alone, on a real clock or a virtual one. After start() no call
// allocates, locks or logs. One thread's.
#pragma once

#include <array>
#include <optional>

#include "firmware/core/cpu_budget.hpp"
#include "firmware/core/shot_player.hpp"
#include "firmware/core/timed_outputs.hpp"

namespace strobe::firmware {

struct Ports {
  Clock& clock;
  ScheduledOutputs& outputs;
  EdgeSource& edges;
  EventSink& sink;
  CommandSource& commands;
};

class Sequencer {
 public:
  /// Longest sleep: the levels of key and e-stop are read at least this often, in case an edge was lost.
  static constexpr Duration kLongestSleep = milliseconds(50);
  /// Longest stretch awake in one turn.
  static constexpr Duration kLongestPoll = milliseconds(1);
  /// A loop that did not turn for so long drops what is armed: who asked for it may have given up.
  static constexpr Duration kStoodStill = milliseconds(500);

  /// last_shot_id: the highest number that any shot of the session folder had.
  /// tick: the kernel's timer tick, unknown: shots start at once.
  Sequencer(const Rig& rig, const Ports& ports, std::int32_t last_shot_id, const Tick& tick = {});

  /// Makes the outputs inactive, reads the inputs, reports STARTED. Returns false if an output failed.
  bool start(const ShortText& detail) noexcept;

  /// One turn; returns no later than kLongestSleep or `latest` from now.
  /// Returns false if an output can no longer be made inactive: the caller must end the process, so that the
  /// guardian takes the outputs over.
  bool step(MonoTime latest) noexcept;

  /// Makes the outputs inactive, aborts a running shot and hands it over, reports STOPPED. Returns false if
  /// an output failed.
  bool stop(const ShortText& why) noexcept;

  State state() const noexcept { return interlock_.state(); }

 private:
  std::optional<std::size_t> wait(MonoTime latest) noexcept;
  void start_interlock() noexcept;
  bool read_levels() noexcept;
  void check_time(MonoTime turned) noexcept;
  void level(Input input, bool active, MonoTime stamp) noexcept;
  void report_level(Input input, bool active, MonoTime stamp) noexcept;
  void dispatch(const Command& command) noexcept;
  const char* unready() const noexcept;
  void arm(const Command& command) noexcept;
  void disarm(const Command& command) noexcept;
  void reset(const Command& command) noexcept;
  void clear(const Command& command) noexcept;
  void fire(const Command& command) noexcept;
  void apply(Interlock::Effect effect) noexcept;
  void fault(const char* why) noexcept;
  void lines_fail(const char* why) noexcept;
  void refuse(const Command& command, std::string_view why) noexcept;
  void report(EventKind kind, const ShortText& detail) noexcept;
  void report_status() noexcept;

  Rig rig_;
  Clock& clock_;
  EdgeSource& edges_;
  EventSink& sink_;
  CommandSource& commands_;
  Interlock interlock_;
  ScheduledOutputs& outputs_;
  ShotPlayer player_;
  CpuBudget awake_;
  MonoTime woken_;
  Duration suspended_;
  std::array<Edge, 64> edge_buffer_;
  std::optional<LoopStatus> reported_;
  MonoTime levels_read_;
};

}  // namespace strobe::firmware
