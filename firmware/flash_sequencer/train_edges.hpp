// A shot's pulses as the edges that a flash sequencer plays.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/flash_sequencer/protocol.hpp"
#include "firmware/core/rig.hpp"
#include "firmware/ports/scheduled_outputs.hpp"

namespace strobe::firmware {

/// The longest on-time of each output, as the rig's.
flash_sequencer::Limits on_time_limits(const Rig& rig);

/// Of one track.
class TrainEdges {
 public:
  /// A pulse begins or ends.
  struct Change {
    flash_sequencer::Ticks at = 0;  ///< after the track's begin, as it is played
    std::size_t pulse = 0;          ///< index into the pulses
    bool on = false;
    std::uint8_t levels = 0;  ///< bits of OutputLine that it changes
    std::uint16_t edge = 0;
  };

  TrainEdges();  ///< allocates what it will need

  /// Of those of the pulses that are of the track's outputs. ahead: the track begins so long before the
  /// pulses' zero. drift: of the rig's clock against the sequencer's. No pulse is longer than its limit;
  /// changes nearer to one another than a sequencer can play are moved apart. Returns false if that are more
  /// edges than it holds, or further apart than it can play. Real-time safe.
  bool build(std::span<const PlannedPulse> pulses, flash_sequencer::Track track, Duration ahead, double drift,
             const flash_sequencer::Limits& limits) noexcept;
  void clear() noexcept;

  std::span<const flash_sequencer::Edge> edges() const noexcept { return edges_; }
  std::span<const Change> changes() const noexcept { return changes_; }  ///< by time

 private:
  std::vector<Change> changes_;
  std::vector<flash_sequencer::Edge> edges_;
};

}  // namespace strobe::firmware
