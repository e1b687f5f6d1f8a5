// The real-time loop, one turn at a time: wait for the next instant, an edge or a command; dispatch the
// interlock; play the shot. Knows no Linux: it runs on the ports, on a real clock or a virtual one. After
// start() no call allocates, locks or logs. One thread's.
#pragma once

#include <array>
#include <optional>

#include "firmware/core/cpu_budget.hpp"
#include "firmware/core/shot_player.hpp"

namespace strobe::firmware {

struct Ports {
  Clock& clock;
  OutputLines& outputs;
  EdgeSource& edges;
  EventSink& sink;
  CommandSource& commands;
};

class Sequencer {
 public:
  /// Longest sleep: inputs are read anew at least this often, should an edge have been lost.
  static constexpr Duration kLongestSleep = milliseconds(50);
  /// Longest stretch awake in one turn.
  static constexpr Duration kLongestPoll = milliseconds(1);

  Sequencer(const Rig& rig, const Ports& ports, std::int32_t last_shot_id);

  /// Outputs inactive, inputs read, STARTED reported. False: an output could not be driven.
  bool start(const ShortText& detail) noexcept;

  /// One turn; returns no later than kLongestSleep or `latest` from now.
  /// False: an output can no longer be made inactive. The caller must end the process, so that the guardian
  /// does it.
  bool step(MonoTime latest) noexcept;

  /// Outputs inactive, a running shot aborted and handed over, STOPPED reported. False: an output could not
  /// be driven.
  bool stop(const ShortText& why) noexcept;

  State state() const noexcept { return interlock_.state(); }

 private:
  std::optional<std::size_t> wait(MonoTime latest) noexcept;
  void read_levels() noexcept;
  void level(Input input, bool active, MonoTime stamp) noexcept;
  void dispatch(const Command& command) noexcept;
  void arm(const Command& command) noexcept;
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
  GuardedOutputs outputs_;
  ShotPlayer player_;
  CpuBudget awake_;
  MonoTime woken_;
  std::array<Edge, 64> edge_buffer_;
  std::optional<LoopStatus> reported_;
  MonoTime levels_read_;
};

}  // namespace strobe::firmware
