// A clock for the threads of the rig's own program: rig time (rig_time.hpp) while the chip keeps one, else the machine's.
// Thread-safe; of a chip that must outlive it.
#pragma once

#include <poll.h>

#include <cstdint>

#include "common/units/time.hpp"

namespace strobe::sim {

namespace gpio {
struct State;
}

class RigClock {
 public:
  RigClock() = default;  ///< the machine's
  explicit RigClock(gpio::State& state) : state_(&state) {}

  MonoTime now() const;
  Duration since_boot() const;  ///< CLOCK_BOOTTIME
  WallTime wall() const;        ///< CLOCK_REALTIME
  void sleep_for(Duration duration) const;
  /// As poll(2).
  int poll(struct pollfd* polled, nfds_t count, Duration timeout) const;
  /// Of what programs draw in a run that is to repeat; 0: they draw as they like.
  std::uint64_t seed() const;

 private:
  gpio::State* state_ = nullptr;
};

}  // namespace strobe::sim
