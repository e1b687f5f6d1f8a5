#include "common/ball/ball.hpp"

#include <cmath>

namespace strobe::ball {

Result<Ball> check(const Ball& ball) {
  // Written so that NaN fails each of them.
  if (!(std::isfinite(ball.diameter_m) && ball.diameter_m > 0.0))
    return fail("ball diameter must be a positive number of metres");
  if (!(std::isfinite(ball.mass_kg) && ball.mass_kg > 0.0))
    return fail("ball mass must be a positive number of kilograms");
  if (!(ball.alpha > 0.0 && ball.alpha <= kThinShellAlpha)) return fail("ball alpha must be in (0, 2/3]");
  return ball;
}

double thick_shell_inertia_kgm2(double mass_kg, double outer_radius_m, double inner_radius_m) {
  const double a = outer_radius_m;
  const double b = inner_radius_m;
  const double fifth = (((a + b) * a + b * b) * a + b * b * b) * a + b * b * b * b;  // (a⁵-b⁵)/(a-b)
  const double third = (a + b) * a + b * b;                                          // (a³-b³)/(a-b)
  return 0.4 * mass_kg * fifth / third;
}

}  // namespace strobe::ball
