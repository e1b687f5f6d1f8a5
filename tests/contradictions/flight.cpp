#include "tests/contradictions/flight.hpp"

#include <cmath>

namespace strobe::contradictions {
namespace {

constexpr double kLongestStep_s = 2e-3;

/// The motion's derivative by time, member by member.
Motion rate(const Motion& m, const Forces& f) {
  const double speed = std::sqrt(m.vx_mps * m.vx_mps + m.vy_mps * m.vy_mps);
  const double rim = f.radius_m * m.omega_radps;
  const double lift = speed > 0.0 ? f.lift_per_m * rim / (2.0 * std::abs(rim) + speed) * speed : 0.0;
  const double drag = f.drag_per_m * speed;
  return {.x_m = m.vx_mps,
          .y_m = m.vy_mps,
          .vx_mps = f.gx_mps2 - drag * m.vx_mps - lift * m.vy_mps,
          .vy_mps = f.gy_mps2 - drag * m.vy_mps + lift * m.vx_mps,
          .angle_rad = m.omega_radps,
          .omega_radps = -f.decay_per_m * speed * m.omega_radps};
}

Motion moved(const Motion& m, const Motion& rate, double h) {
  return {m.x_m + h * rate.x_m,
          m.y_m + h * rate.y_m,
          m.vx_mps + h * rate.vx_mps,
          m.vy_mps + h * rate.vy_mps,
          m.angle_rad + h * rate.angle_rad,
          m.omega_radps + h * rate.omega_radps};
}

Motion step(const Motion& m, const Forces& f, double h) {
  const Motion a = rate(m, f);
  const Motion b = rate(moved(m, a, 0.5 * h), f);
  const Motion c = rate(moved(m, b, 0.5 * h), f);
  const Motion d = rate(moved(m, c, h), f);
  return moved(moved(moved(moved(m, a, h / 6.0), b, h / 3.0), c, h / 3.0), d, h / 6.0);
}

}  // namespace

Motion flown(const Motion& from, const Forces& forces, double duration_s) {
  const double steps = std::ceil(std::abs(duration_s) / kLongestStep_s);
  const int count = steps < 1.0 ? 1 : static_cast<int>(steps);
  Motion motion = from;
  for (int i = 0; i < count; ++i) motion = step(motion, forces, duration_s / count);
  return motion;
}

}  // namespace strobe::contradictions
