#include "sim/shoot/window.hpp"

#include <algorithm>
#include <cmath>

#include "sim/motion/ball_path.hpp"
#include "sim/random/draws.hpp"
#include "sim/rig/camera.hpp"

namespace strobe::sim {

namespace {

constexpr double kLongest_s = 0.25;
constexpr double kStep_s = 1e-3;

double seen_for_s(const Camera& camera, const BallPath& path, double step_s) {
  double t = 0.0;
  while (std::abs(t) < kLongest_s) {
    const BallState s = path.at(t);
    if (path.beyond_last_bounce(t, s) || !camera.sees(s.x_m, s.y_m)) break;
    t += step_s;
  }
  return std::abs(t);
}

}  // namespace

Window crossing_window(const Scene& scene, double period_s) {
  const Scene mean = without_spread(scene);
  const auto path = BallPath::make(mean, draw_shot_conditions(mean, 1, 1));
  const Camera camera(mean);
  const double before = path ? seen_for_s(camera, *path, -kStep_s) : kLongest_s;
  const double after = path ? seen_for_s(camera, *path, kStep_s) : kLongest_s;
  const MachineSettings& m = scene.machine;
  const double slowest = std::max(0.2, 1.0 - kLargestNormal * m.speed_sd_mps / m.speed_mps -
                                           kLargestNormal * m.angle_sd_rad * std::tan(std::abs(m.angle_rad)));
  const double wait = kLargestNormal * m.lag_sd_s + period_s;
  return {std::min(before / slowest, kLongest_s) + wait, std::min(after / slowest, kLongest_s) + wait};
}

}  // namespace strobe::sim
