#include "tests/common/contact_ode/drawn_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

namespace strobe::testing {

ContactCase draw_contact(ContactDraws& draws) {
  const double degree = std::numbers::pi / 180.0, speed = draws.over_decades(1e-6, 1e3);
  const double angle = draws.one_in(2) ? draws.over_decades(0.01, 90.0) : draws.between(5.0, 90.0);
  ContactCase c;
  c.touchdown = {speed * std::cos(angle * degree), -speed * std::sin(angle * degree), 0.0};
  if (draws.one_in(3))
    c.touchdown.omega_radps = std::clamp(draws.between(-3.0, 3.0) * speed / 0.03255, -1e5, 1e5);
  else if (!draws.one_in(6))
    c.touchdown.omega_radps = (draws.one_in(2) ? 1.0 : -1.0) * draws.over_decades(1e-3, 1e5);
  c.coefficients.e = draws.one_in(10) ? 1.0 : draws.between(0.14, 1.0);
  c.coefficients.mu = draws.one_in(20) ? 0.0 : draws.over_decades(0.01, 10.0);
  c.coefficients.dwell_s = draws.over_decades(1e-6, 1.0);
  c.coefficients.stiffness_ratio = draws.between(0.3, 3.0);
  c.coefficients.damping_ratio = draws.one_in(3) ? 0.0 : draws.between(0.1, 2.0);
  c.coefficients.offset_share = draws.one_in(3) ? 0.0 : draws.between(0.0, 0.3);
  return c;
}

void put_weight_along(ContactCase& c, ContactDraws& draws) {
  // Up to what stops the slip, or sets the ball going, within a contact.
  const double most =
      std::min(1e3, std::hypot(c.touchdown.vx_mps, c.touchdown.vy_mps) / c.coefficients.dwell_s);
  c.coefficients.gravity_along_mps2 = (draws.one_in(2) ? 1.0 : -1.0) * most * draws.over_decades(1e-4, 1.0);
}

std::string text_of(const ContactCase& c) {
  char line[500];
  std::snprintf(line, sizeof line,
                "vx %.17g vy %.17g omega %.17g e %.17g mu %.17g dwell %.17g kt %.17g ct %.17g offset %.17g "
                "w0 %.17g g %.17g along %.17g",
                c.touchdown.vx_mps, c.touchdown.vy_mps, c.touchdown.omega_radps, c.coefficients.e,
                c.coefficients.mu, c.coefficients.dwell_s, c.coefficients.stiffness_ratio,
                c.coefficients.damping_ratio, c.coefficients.offset_share,
                c.coefficients.offset_reference_mps, c.coefficients.gravity_mps2,
                c.coefficients.gravity_along_mps2);
  return line;
}

ball::Ball contact_ball() { return {.alpha = impact::kContactAlpha}; }

ReferenceContact reference_of(const ContactCase& c, int intervals) {
  return reference_contact(contact_ball(), c.touchdown, c.coefficients, intervals);
}

double relative(const Quad& got, const Quad& expected, double scale) {
  return std::abs(static_cast<double>(got - expected)) / scale;
}

double tangential_scale(const ContactCase& c) {
  const double radius = contact_ball().radius_m(), normal = -c.touchdown.vy_mps;
  const double slip = std::abs(std::fma(radius, c.touchdown.omega_radps, c.touchdown.vx_mps));
  const double depth = std::min(1.0, normal * c.coefficients.dwell_s / 3.0 / radius);
  const double pulled = std::abs(c.coefficients.gravity_along_mps2) * c.coefficients.dwell_s;
  return std::min(2.0 * c.coefficients.mu * normal, slip + pulled) +
         2.0 * c.coefficients.offset_share * std::sqrt(depth) * normal + pulled;
}

double rounding_of(const ContactCase& c) {
  return 4.0 * std::numeric_limits<double>::epsilon() *
         (std::abs(c.touchdown.vx_mps) + contact_ball().radius_m() * std::abs(c.touchdown.omega_radps) -
          c.touchdown.vy_mps);
}

double lift_off_error(const ContactCase& c, const impact::Motion& lift_off, double dwell_s,
                      const ReferenceContact& reference, double tolerance) {
  const double radius = contact_ball().radius_m();
  const double floor = tangential_scale(c) + rounding_of(c) / tolerance;
  return std::max({relative(lift_off.vy_mps, reference.vy_mps, -c.touchdown.vy_mps),
                   relative(lift_off.vx_mps, reference.vx_mps, floor),
                   relative(radius * Quad(lift_off.omega_radps), radius * reference.omega_radps, floor),
                   relative(dwell_s, reference.dwell_s, c.coefficients.dwell_s)});
}

}  // namespace strobe::testing
