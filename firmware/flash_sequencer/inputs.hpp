// Edge source on a flash sequencer: it stamps the edges, and their stamps are told by the machine's clock.
#pragma once

#include "firmware/core/rig.hpp"
#include "firmware/flash_sequencer/link.hpp"
#include "firmware/flash_sequencer/witness.hpp"
#include "firmware/ports/edge_source.hpp"

namespace strobe::firmware {

/// Real-time safe; one thread's.
class FlashSequencerInputs final : public EdgeSource {
 public:
  /// All must outlive this.
  /// witness: null: the sensors are on the sequencer alone.
  FlashSequencerInputs(const Rig& rig, FlashSequencerLink& link, Clock& clock, Witness* witness = nullptr)
      : rig_(rig), link_(link), clock_(clock), witness_(witness) {}

  std::optional<std::size_t> wait(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<std::size_t> poll(MonoTime until, std::span<Edge> edges) noexcept override;
  std::optional<bool> level(Input input) noexcept override;
  std::int64_t kernel_overflows() const noexcept override { return link_.lost_edges(); }

 private:
  std::optional<std::size_t> take(std::span<Edge> edges) noexcept;

  const Rig& rig_;
  FlashSequencerLink& link_;
  Clock& clock_;
  Witness* witness_;
};

}  // namespace strobe::firmware
