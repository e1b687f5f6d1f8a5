#include "common/ball/ball.hpp"

#include <cmath>

namespace strobe::ball {

Result<Ball> check(const Ball& ball) {
  // Written so that NaN fails each of them.
  if (!(std::isfinite(ball.diameter_m) && ball.diameter_m > 0.0))
    return fail("ball diameter must be a positive number of metres");
  if (!(std::isfinite(ball.mass_kg) && ball.mass_kg > 0.0))
    return fail("ball mass must be a positive number of kilograms");
  if (!(std::isfinite(ball.alpha) && ball.alpha > 0.0 && ball.alpha <= kThinShellAlpha))
    return fail("ball alpha must be in (0, 2/3]");
  if (ball.diameter_m > kMaxSize || ball.mass_kg > kMaxSize || ball.diameter_m < kMinSize ||
      ball.mass_kg < kMinSize || ball.alpha < kMinSize)
    return fail("ball diameter, mass and alpha must lie between 1e-30 and 1e30");
  return ball;
}

Result<double> thick_shell_inertia_kgm2(double mass_kg, double outer_radius_m, double inner_radius_m) {
  // isfinite() first: it is silent about a NaN, comparisons raise an exception.
  if (!(std::isfinite(mass_kg) && mass_kg >= kMinSize && mass_kg <= kMaxSize))
    return fail("shell mass must be a positive number of kilograms, 1e-30 to 1e30");
  if (!(std::isfinite(outer_radius_m) && outer_radius_m >= kMinSize && outer_radius_m <= kMaxSize))
    return fail("outer radius must be a positive number of metres, 1e-30 to 1e30");
  if (!(std::isfinite(inner_radius_m) && inner_radius_m >= 0.0 && inner_radius_m <= outer_radius_m))
    return fail("inner radius must be from 0 to the outer radius");
  const double r = inner_radius_m / outer_radius_m;
  const double fifth = 1.0 + r * (1.0 + r * (1.0 + r * (1.0 + r)));  // (1-r⁵)/(1-r)
  const double third = 1.0 + r * (1.0 + r);                          // (1-r³)/(1-r)
  return 0.4 * mass_kg * outer_radius_m * outer_radius_m * (fifth / third);
}

}  // namespace strobe::ball
