// Plays a firmware on a rig in virtual time: one shot of a free train, all answers collected.
#pragma once

#include <vector>

#include "sim/rig/rig.hpp"

namespace strobe::sim::test {

struct ShotTimes {
  Duration period = milliseconds(3);
  Duration exposure = milliseconds(500);      ///< after the shutter has opened
  Duration impact_after = milliseconds(250);  ///< ball at the plate after the shutter has opened
  bool throw_ball = true;
};

/// A scene of thrown balls that needs no file: 17 m/s at 23 degrees, gripping, without any spread or noise.
Scene plain_scene();

/// Takes away every spread, jitter and noise.
void make_exact(Scene& scene);

class VirtualRigFixture {
 public:
  explicit VirtualRigFixture(const Scene& scene, std::uint64_t seed = 1) : rig_(scene, seed, now_) {}

  /// One shot; gives its exposure. Drives are in drives() until the next shot.
  Exposure shoot(const ShotTimes& times = {});

  const std::vector<Drive>& drives() const { return drives_; }
  std::vector<Drive> drives_of(RigLine line, int level) const;
  MonoTime now() const { return now_; }
  Rig& rig() { return rig_; }

 private:
  MonoTime now_ = from_ns(1'000'000'000'000);
  Rig rig_;
  std::vector<Drive> drives_;
};

struct Shot {
  VirtualRigFixture fixture;
  Exposure exposure = fixture.shoot();
};
inline Shot shot_of(const Scene& scene) { return {.fixture = VirtualRigFixture(scene)}; }

}  // namespace strobe::sim::test
