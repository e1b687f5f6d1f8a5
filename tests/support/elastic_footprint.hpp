// Oblique impact of an elastic sphere with the whole footprint followed: Hertz and Mindlin with local Coulomb friction,
// as Maw, Barber and Fawcett solved it annulus by annulus. Here by the method of dimensionality reduction (V. L. Popov,
// M. Hess): a foundation of independent springs under the profile x²/R, each with a normal stiffness E*·dx and a
// tangential one of kappa·E*·dx, gripping or slipping on its own at mu times its own load, has the force and compliance
// of the axisymmetric contact at any history. Small steps, no closed form, nothing shared with the tested code.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace strobe::testing {

struct FootprintImpact {
  double slip = 0.0;  ///< w = (vx + R·omega)/|vy| at touchdown
  double mu = 0.0, kappa = 1.0, alpha = 0.4;
};

/// w at lift-off, e = 1. Units: R, mass and |vy| 1, E* 1; the result depends on none of them. Second order in steps.
inline double footprint_slip_lo(const FootprintImpact& impact, int springs, int steps) {
  // 1/2 = (8/15)·E*·sqrt(R)·d^(5/2) at the deepest point; the contact lasts 2.943 d/|vy| (Hertz).
  const double deepest = std::pow(15.0 / 16.0, 0.4);
  const double dx = std::sqrt(deepest) / springs, dt = 2.943 * deepest / steps;
  const double beta = 1.0 + 1.0 / impact.alpha;
  std::vector<double> stretch(static_cast<std::size_t>(springs), 0.0);
  double depth = 0.0, approach = 1.0, w = impact.slip, friction = 0.0;
  while (true) {
    const double middle = depth + approach * dt / 2.0;
    if (middle <= 0.0) return w;
    approach -= 4.0 / 3.0 * std::pow(middle, 1.5) * dt;
    depth = middle + approach * dt / 2.0;
    const double moved = (w - beta * friction * dt / 2.0) * dt;
    double sum = 0.0;
    for (int i = 0; i < springs; ++i) {
      const double x = (i + 0.5) * dx, pressed = std::max(0.0, depth - x * x);
      double& u = stretch[static_cast<std::size_t>(i)];
      const double limit = impact.mu * pressed / impact.kappa;
      u = std::clamp(u + moved, -limit, limit);
      sum += 2.0 * impact.kappa * u * dx;
    }
    w -= beta * (friction + sum) / 2.0 * dt;
    friction = sum;
    if (depth <= 0.0) return w;
  }
}

}  // namespace strobe::testing
