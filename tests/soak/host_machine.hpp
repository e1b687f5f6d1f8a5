// A host's machine in the virtual lab: its clocks, its session folder's log, and the host that runs on it. One thread's.
#pragma once

#include <cmath>
#include <memory>

#include "tests/soak/bus.hpp"
#include "tests/soak/virtual_host.hpp"

namespace strobe::soak {

struct HostMachine {
  HostMachine(Receiver as, Random& random)
      : receiver(as),
        rate(1.0 + random.uniform(-50e-6, 50e-6)),
        origin(from_ns<HostTime>(std::llround(random.uniform(1e9, 1e15)))) {}

  /// world: the time that passes for all, on whatever machine.
  host::HostReading read(MonoTime world) const {
    const HostTime since_boot = origin + Duration{std::llround(static_cast<double>(to_ns(world)) * rate)};
    return {since_boot - slept, WallTime{since_boot.time_since_epoch()}, since_boot.time_since_epoch()};
  }

  Receiver receiver;
  double rate;
  HostTime origin;
  std::unique_ptr<VirtualHost> process;  ///< null: none runs
  HostLog log;
  MonoTime due = kFarFuture;  ///< its next step
  MonoTime wakes;             ///< the machine sleeps until then
  Duration slept{};
};

}  // namespace strobe::soak
