// The same scene and seed give the same bytes, whatever the machine's load and in whichever thread.
#include <atomic>
#include <string>
#include <thread>

#include "common/messages/json_conversions.hpp"
#include "sim/rig/truth.hpp"
#include "sim/shoot/shoot.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

/// Every effect and every spread on.
Scene busy_scene() {
  Scene scene;
  scene.name = "busy";
  scene.machine.speed_sd_mps = 0.3;
  scene.machine.spin_sd_radps = 20.0;
  scene.bounce.e_speed_mps = 6.6;
  scene.bounce.e_sd = scene.bounce.mu_sd = scene.bounce.offset_share_sd = 0.02;
  scene.bounce.dwell_sd_s = 0.2e-3;
  scene.lamps.flash_s = 5e-6;
  scene.camera.distance_m = 1.5;
  scene.camera.off_plane_sd_m = 0.01;
  scene.camera.distortion = 0.02;
  scene.camera.pixels = true;
  scene.faults = {{.kind = FaultKind::flash_late, .flash_from_impact = -2, .delay = microseconds(160)}};
  return scene;
}

std::string bytes_of(std::uint64_t seed, int shots) {
  auto shooter = Shooter::make(busy_scene(), seed);
  std::string text;
  for (int shot = 1; shot <= shots; ++shot) {
    const SimulatedShot result = shooter->shoot(shot);
    text +=
        messages::frame_to_json(result.frame) + '\n' + truth_line(shooter->scene(), result.exposure, shot);
  }
  return text;
}

}  // namespace

TEST_GROUP(ShootRepeat){};

TEST(ShootRepeat, GivesTheSameBytesInAnotherThreadUnderLoad) {
  constexpr int kShots = 12;
  const std::string quiet = bytes_of(7, kShots);
  std::atomic<bool> done{false};
  std::string loaded, beside;
  {
    const std::jthread load([&] {
      for (volatile unsigned spin = 0; !done;) spin = spin + 1;
    });
    const std::jthread other([&] { beside = bytes_of(8, kShots); });
    std::jthread([&] { loaded = bytes_of(7, kShots); }).join();
    done = true;
  }
  CHECK_EQUAL(loaded, quiet);
  CHECK(quiet != beside);
  CHECK_EQUAL(bytes_of(8, kShots), beside);
}
