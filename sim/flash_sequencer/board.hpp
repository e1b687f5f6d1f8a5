// The flash sequencer's chip as its logic sees it: a clock with an offset and a drift of its own, outputs
// that play a train to the tick, inputs that are stamped, and key and e-stop that cut at once. Time comes
// from outside: no clock, no threads, no I/O. Not thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "common/flash_sequencer/hardware.hpp"
#include "common/units/time.hpp"
#include "sim/random/draws.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim::sequencer {

struct PinChange {
  MonoTime at;
  RigLine line = RigLine::strobe_a;
  int level = 0;
};

class Board final : public flash_sequencer::Hardware {
 public:
  using Ticks = flash_sequencer::Ticks;

  /// Its crystal is off by up to kMaxDrift_ppm; seed: of what it draws.
  explicit Board(std::uint64_t seed);
  static constexpr double kMaxDrift_ppm = 30.0;

  /// Its clock begins; all outputs are inactive.
  void power_up(MonoTime now);
  /// Plays what is due up to then. Times go on, never back.
  void advance(MonoTime now);
  /// When the next edge is due; far in the future if there is none.
  MonoTime next_edge() const;
  /// Of an input line, physical; others are ignored. An edge of the past counts from now on.
  void line_changed(RigLine line, int level, MonoTime at);
  /// What the pins did since the last call.
  std::vector<PinChange> take_pin_changes();

  Ticks ticks(MonoTime instant) const;
  MonoTime instant(Ticks ticks) const;

  Ticks now() override { return ticks(now_); }
  void prepare(std::span<flash_sequencer::Edge> movers, std::span<flash_sequencer::Edge> lamps) override;
  void start(Ticks at, bool gated) override;
  void listen_to_gate(bool listens) override { listens_ = listens; }
  flash_sequencer::Progress progress() override { return progress_; }
  void cut() override;
  bool release() override;
  flash_sequencer::CutCause cut_by_itself() override { return cut_by_itself_; }
  std::uint8_t inputs() override { return inputs_; }
  std::uint8_t outputs() override { return outputs_; }
  bool pop_input(flash_sequencer::InputEdge& edge) override;
  std::uint16_t lost_inputs() override { return lost_inputs_; }
  std::uint32_t random() override;

 private:
  struct Playing {
    std::span<const flash_sequencer::Edge> edges;
    Ticks due = flash_sequencer::kNoTicks;  ///< of the next one
  };

  flash_sequencer::CutCause forbidden_by() const;
  Playing* next_playing(Ticks until);
  void begin(flash_sequencer::Track track, Ticks at);
  void play_edge(Playing& playing);
  void stop(MonoTime at);
  void set_outputs(std::uint8_t levels, MonoTime at);

  Draws draws_;
  double ticks_per_ns_;
  MonoTime powered_up_, now_;
  std::array<Playing, flash_sequencer::kTrackCount> playing_;
  flash_sequencer::Progress progress_;
  Ticks starts_at_ = flash_sequencer::kNoTicks;
  bool gated_ = false, listens_ = false, released_ = false;
  flash_sequencer::CutCause cut_by_itself_ = flash_sequencer::CutCause::none;
  std::uint8_t inputs_ = flash_sequencer::bit(flash_sequencer::InputLine::estop);  ///< until a line is told
  std::uint8_t outputs_ = 0;
  std::deque<flash_sequencer::InputEdge> edges_;
  std::uint16_t lost_inputs_ = 0;
  std::vector<PinChange> pin_changes_;
};

}  // namespace strobe::sim::sequencer
