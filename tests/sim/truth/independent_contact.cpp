#include "tests/sim/truth/independent_contact.hpp"

#include <algorithm>
#include <cmath>

namespace strobe::testing {

namespace {

/// Damped oscillation in units of sqrt(m/k) and |vy|, from the surface down.
struct Oscillation {
  double zeta;
  double q() const { return std::sqrt(1.0 - zeta * zeta); }
  double release() const { return 2.0 * std::acos(zeta) / q(); }  ///< where the force is zero
  double depth(double tau) const { return std::exp(-zeta * tau) * std::sin(q() * tau) / q(); }
  double speed(double tau) const {
    return std::exp(-zeta * tau) * (std::cos(q() * tau) - zeta / q() * std::sin(q() * tau));
  }
};

/// e falls with zeta: halve the interval.
double damping_ratio_of(double e) {
  double low = 0.0, high = 0.999;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (std::exp(-middle * Oscillation{middle}.release()) > e ? low : high) = middle;
  }
  return low;
}

struct Tangential {
  double x = 0.0, turned = 0.0, vx = 0.0, omega = 0.0, stretch = 0.0;
};

Tangential plus(const Tangential& a, const Tangential& slope, double h) {
  return {a.x + h * slope.x, a.turned + h * slope.turned, a.vx + h * slope.vx, a.omega + h * slope.omega,
          a.stretch + h * slope.stretch};
}

}  // namespace

std::vector<ContactPoint> contact_course(const ContactInput& in, int steps) {
  const Oscillation o{damping_ratio_of(in.e)};
  // Released at o.release() with depth 2·zeta·speed: that much longer until the centre is back.
  const double frequency = (o.release() + 2.0 * o.zeta) / in.dwell_s;
  const double k = in.mass_kg * frequency * frequency, kt = in.stiffness_ratio * k;
  const double ct = in.damping_ratio * std::sqrt(kt * in.mass_kg);
  const double metre = -in.vy_mps / frequency;
  const auto depth_m = [&](double tau) {
    return tau < o.release() ? metre * o.depth(tau)
                             : metre * (o.depth(o.release()) + o.speed(o.release()) * (tau - o.release()));
  };
  const auto slope = [&](const Tangential& z, double tau) {
    const double normal = tau < o.release() ? k * metre * (o.depth(tau) + 2.0 * o.zeta * o.speed(tau)) : 0.0;
    const double slip = z.vx + in.radius_m * z.omega;
    double force = kt * z.stretch + ct * slip, stretching = slip;
    if (std::abs(force) > in.mu * normal) {
      force = std::copysign(in.mu * normal, force);
      stretching = (force - kt * z.stretch) / ct;
    }
    const double y = std::clamp(depth_m(tau), 0.0, in.radius_m), w = in.radius_m * z.omega;
    const double offset = -in.offset_share * std::sqrt(y * (2.0 * in.radius_m - y)) * w /
                          std::hypot(w, in.offset_reference_mps);
    const double inertia = in.alpha * in.mass_kg * in.radius_m * in.radius_m;
    return Tangential{z.vx, z.omega, -force / in.mass_kg, (offset * normal - in.radius_m * force) / inertia,
                      stretching};
  };
  std::vector<ContactPoint> course;
  Tangential z{.vx = in.vx_mps, .omega = in.omega_radps};
  const double h = in.dwell_s / steps;
  for (int i = 0; i <= steps; ++i) {
    const double tau = frequency * h * i;
    course.push_back({z.x, -std::max(0.0, depth_m(tau)), z.turned, z.vx, z.omega});
    z = plus(z, slope(plus(z, slope(z, tau), 0.5 * h), tau + 0.5 * frequency * h), h);
  }
  return course;
}

}  // namespace strobe::testing
