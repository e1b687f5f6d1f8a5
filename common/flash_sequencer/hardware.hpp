// Port: what a flash sequencer's logic needs of the chip that it runs on.
#pragma once

#include <span>

#include "common/flash_sequencer/protocol.hpp"

namespace strobe::flash_sequencer {

struct Progress {
  Ticks started = kNoTicks;        ///< when the movers' track began, as it was stamped
  Ticks burst_started = kNoTicks;  ///< the lamps' track: the same instant, or the gate's edge
  std::array<std::uint16_t, kTrackCount> played{};
  bool underrun = false;  ///< an edge came too late
};

/// One thread's. No call waits for an instant or an edge.
class Hardware {
 public:
  virtual ~Hardware() = default;
  virtual Ticks now() = 0;
  /// Gets the tracks ready to be played; they stay where they are, and belong to the hardware until cut() or
  /// the end of the train; empty ones give back those that were not started.
  virtual void prepare(std::span<Edge> movers, std::span<Edge> lamps) = 0;
  /// Plays both tracks from that instant on, the lamps' by the gate's next active edge if gated. After
  /// prepare().
  virtual void start(Ticks at, bool gated) = 0;
  /// Of a gated train that plays: from now on the gate's edge counts, or no longer.
  virtual void listen_to_gate(bool listens) = 0;
  /// Since prepare(); after cut() or the train's end as it was then.
  virtual Progress progress() = 0;
  /// All outputs are inactive from now on and stay so until release().
  virtual void cut() = 0;
  /// The outputs may be driven again. Returns false while key or e-stop forbid it.
  virtual bool release() = 0;
  /// Whether key or e-stop have cut the outputs by themselves: without this program, since release().
  virtual CutCause cut_by_itself() = 0;
  virtual std::uint8_t inputs() = 0;   ///< bits of InputLine
  virtual std::uint8_t outputs() = 0;  ///< bits of OutputLine, as they are on the pins
  /// The oldest edge that was stamped; its number is the caller's to set. False: none.
  virtual bool pop_input(InputEdge& edge) = 0;
  virtual std::uint16_t lost_inputs() = 0;  ///< edges that had no room, since the start
  virtual std::uint32_t random() = 0;
};

}  // namespace strobe::flash_sequencer
