// Energy along the rig's whole paths: flight, contact, flight.
#include <cstdio>
#include <random>

#include "sim/motion/ball_path.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;

namespace {

constexpr double kGravity_mps2 = 9.80665;

/// Any ball on any surface within a scene's ranges.
Scene any_scene(std::mt19937_64& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Scene scene;
  scene.machine.speed_mps = between(1.0, 60.0);
  scene.machine.angle_rad = -between(5.0, 85.0) * std::numbers::pi / 180.0;
  scene.machine.spin_radps = between(-600.0, 600.0);
  scene.bounce.e = between(0.2, 0.98);
  scene.bounce.e_slope_spm = 0.0;
  scene.bounce.mu = between(0.0, 1.2);
  scene.bounce.dwell_s = between(1e-3, 8e-3);
  scene.bounce.stiffness_ratio = between(0.3, 3.0);
  scene.bounce.damping_ratio = between(0.05, 2.0);
  scene.bounce.offset_share = between(0.0, 0.4);
  return scene;
}

/// Of motion and height, J. In contact the springs hold more, never less than nothing.
double energy_j(const Scene& scene, const BallState& s) {
  const ball::Ball& b = scene.ball;
  return 0.5 * b.mass_kg * (s.vx_mps * s.vx_mps + s.vy_mps * s.vy_mps) +
         0.5 * b.inertia_kgm2() * s.omega_radps * s.omega_radps + b.mass_kg * kGravity_mps2 * s.y_m;
}

}  // namespace

TEST_GROUP(PathEnergy){};

// The integration's tolerance is 1e-9 of the speeds.
TEST(PathEnergy, NeverGrowsFromTouchdownToLiftOffAndBeyond) {
  const unsigned seed = std::random_device{}();
  std::mt19937_64 random(seed);
  int bounced = 0;
  for (int i = 0; i < 300; ++i) {
    const Scene scene = any_scene(random);
    const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
    char text[80];
    std::snprintf(text, sizeof text, "seed %u, scene %d", seed, i);
    if (!path) continue;  // the weight holds a slow ball
    ++bounced;
    const double start = energy_j(scene, path->at(0.0));
    for (int k = 1; k <= 100; ++k)
      CHECK_TEXT(energy_j(scene, path->at(path->dwell_s() * k / 100.0)) <= start * (1.0 + 1e-8), text);
    double before = energy_j(scene, path->at(path->dwell_s()));
    for (int k = 1; k <= 20; ++k) {
      const double now = energy_j(scene, path->at(path->dwell_s() + 5e-3 * k));
      CHECK_TEXT(now <= before * (1.0 + 1e-12), text);
      before = now;
    }
    // Towards touchdown too the air only takes.
    CHECK_TEXT(energy_j(scene, path->at(-0.05)) >= start * (1.0 - 1e-12), text);
  }
  CHECK(bounced > 250);
}
