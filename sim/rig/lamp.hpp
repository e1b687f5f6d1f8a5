// One strobe lamp: a delay, some jitter, a capacitor that must recharge, and faults.
// Virtual time, no clock; one object per lamp, not thread-safe; allocates only if a fault occurs.
#pragma once

#include <optional>
#include <vector>

#include "sim/random/draws.hpp"
#include "sim/rig/exposure.hpp"
#include "sim/scene/faults.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

class LampModel {
 public:
  /// `scene` must outlive the lamp.
  LampModel(const Scene& scene, std::uint64_t seed, Lamp lamp) : scene_(scene), seed_(seed), lamp_(lamp) {}

  /// The flashes that a rising edge of the lamp's line makes: one, none, or with a fault two; in order of
  /// time. Kinds of faults that occurred are appended to `occurred`.
  FlashTimes on_pulse(MonoTime edge, const FlashPlace& place, std::vector<FaultKind>& occurred);

  /// Discards earlier flashes and draws.
  void restart() {
    last_flash_ = kNoTime;
    draws_.reset();
  }

  /// Jitter of the sensor's edge for the latest pulse's flashes.
  double sensor_jitter_s() const { return sensor_jitter_s_; }

  /// Whether the sensor that looks at this lamp works in this shot.
  bool sensor_works(int shot) const;

 private:
  Draws& draws(int shot);

  const Scene& scene_;
  std::uint64_t seed_;
  Lamp lamp_;
  MonoTime last_flash_ = kNoTime;
  std::optional<Draws> draws_;  ///< of the shot below
  int draws_shot_ = 0;
  double sensor_jitter_s_ = 0.0;
};

}  // namespace strobe::sim
