// The tablet operator in virtual time: when a shot is announced, finds the exposure of that time, digitizes
// it and sends the frame after a delay; a shot announced again is sent again. One thread's; allocates.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "common/shot/shot_key.hpp"
#include "sim/rig/exposure.hpp"
#include "tests/soak/bus.hpp"

namespace strobe::soak {

class VirtualTabletOperator {
 public:
  VirtualTabletOperator(const sim::Scene& scene, std::uint64_t seed) : scene_(scene), seed_(seed) {}

  void add(sim::Exposure exposure);
  /// The exposure that began within the time of a shot; nullptr if there is none.
  const sim::Exposure* exposure_of(MonoTime shot_start, MonoTime shot_end) const;

  void announce(ShotKey key, MonoTime start, MonoTime now);
  MonoTime next_due() const { return tasks_.next(); }
  /// The encoded frame that is due; empty if there is none.
  std::vector<std::uint8_t> take(MonoTime now);

 private:
  struct Task {
    ShotKey key;
    MonoTime start, announced;
  };
  const sim::Scene& scene_;
  std::uint64_t seed_;
  std::vector<std::shared_ptr<const sim::Exposure>> exposures_;
  Timeline<Task> tasks_;
  std::map<ShotKey, std::vector<std::uint8_t>> measured_;
  std::map<ShotKey, MonoTime> announced_;
};

}  // namespace strobe::soak
