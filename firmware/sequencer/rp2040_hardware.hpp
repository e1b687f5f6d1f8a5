// The port of the flash sequencer's logic to the RP2040: tracks by PIO and DMA, stamps by PIO.
#pragma once

#include <array>

#include "common/flash_sequencer/hardware.hpp"

namespace strobe::sequencer {

class Rp2040Hardware final : public flash_sequencer::Hardware {
 public:
  using Ticks = flash_sequencer::Ticks;

  /// Outputs are driven from now on, inactive, and cut. After set_up_chip(). Returns false if the clocks of
  /// the stamps do not agree: the chip is to be started again.
  bool start();
  /// To be called often: begins the train at its instant, takes stamps, polls the slow inputs.
  void poll();
  /// When the timer had that low word, at most an hour ago.
  Ticks ticks_of(std::uint32_t timer_us);

  Ticks now() override;
  void prepare(std::span<flash_sequencer::Edge> movers, std::span<flash_sequencer::Edge> lamps) override;
  void start(Ticks at, bool gated) override;
  void listen_to_gate(bool listens) override;
  flash_sequencer::Progress progress() override;
  void cut() override;
  bool release() override;
  flash_sequencer::CutCause cut_by_itself() override;
  std::uint8_t inputs() override;
  std::uint8_t outputs() override;
  bool pop_input(flash_sequencer::InputEdge& edge) override;
  std::uint16_t lost_inputs() override { return lost_inputs_; }
  std::uint32_t random() override;

 private:
  struct Track {
    std::array<flash_sequencer::Edge, flash_sequencer::kMaxEdges> words;  ///< as its machine takes them
    std::size_t count = 0;
  };
  bool calibrate();
  void load(std::size_t index, std::span<const flash_sequencer::Edge> edges, unsigned entry);
  void begin();
  void keep_gate(bool open);
  void take_stamps();
  void poll_levels();
  void push_input(const flash_sequencer::InputEdge& edge);
  std::uint16_t played(std::size_t index) const;
  Ticks stamped(std::uint32_t count);

  std::uint32_t last_systick_ = 0xffffff;
  Ticks now_ = 0;
  Ticks stamps_begin_ = 0;  ///< when PIO1's count was all ones
  std::uint32_t last_timer_us_ = 0;
  std::int64_t timer_us_ = 0;
  Ticks timer_begin_ = 0;  ///< when the timer was 0

  std::array<Track, flash_sequencer::kTrackCount> tracks_;
  bool waits_ = false;  ///< for start_at_
  Ticks start_at_ = 0;
  bool gated_ = false;
  bool gate_wanted_ = false;
  bool gate_open_ = false;
  bool cut_ = false;  ///< by the program
  flash_sequencer::Progress progress_;

  std::array<flash_sequencer::InputEdge, 128> inputs_;
  std::size_t first_input_ = 0;
  std::size_t end_input_ = 0;
  std::uint16_t lost_inputs_ = 0;
  std::uint8_t polled_ = 0;
};

}  // namespace strobe::sequencer
