// Pairs the flash sensors' edges as a flash sequencer stamped them with those of the same sensors on a GPIO
// chip, which the kernel stamped.
#pragma once

#include <array>
#include <cstddef>

#include "firmware/flash_sequencer/link.hpp"
#include "firmware/ports/edge_source.hpp"

namespace strobe::firmware {

/// Real-time safe; one thread's.
class Witness {
 public:
  /// Edges further apart are not the same. Lamps recharge for longer than twice this.
  static constexpr Duration kFarthest = microseconds(500);

  /// kernel: has the sensors alone. Both must outlive this.
  Witness(EdgeSource& kernel, FlashSequencerLink& link) : kernel_(kernel), link_(link) {}

  /// stamp: the sequencer's, of a sensor's edge.
  void note(Input sensor, flash_sequencer::Ticks stamp) noexcept;
  /// Takes the kernel's edges that have come, and tells the link of each that both have stamped.
  void look() noexcept;

 private:
  static constexpr std::size_t kSensors = 2;
  static constexpr std::size_t kRoom = 64;
  template <typename Stamp>
  struct Queue {
    std::array<Stamp, kRoom> stamps{};
    std::size_t first = 0, count = 0;
    const Stamp& front() const { return stamps[first]; }
    void pop() {
      first = (first + 1) % kRoom;
      --count;
    }
    /// Without room the oldest goes.
    void push(Stamp stamp) {
      if (count == kRoom) pop();
      stamps[(first + count++) % kRoom] = stamp;
    }
  };
  void pair(std::size_t sensor) noexcept;

  EdgeSource& kernel_;
  FlashSequencerLink& link_;
  std::array<Queue<flash_sequencer::Ticks>, kSensors> sequencers_;
  std::array<Queue<MonoTime>, kSensors> kernels_;
};

}  // namespace strobe::firmware
