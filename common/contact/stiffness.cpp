#include "common/contact/stiffness.hpp"

#include <cmath>
#include <numbers>

#include "common/impact/ode/normal_spring.hpp"

namespace strobe::contact {

tl::expected<Stiffness, impact::InputError> stiffness(const SpinPulseInput& input) {
  const auto pulse = SpinPulse::make(input);
  if (!pulse) return tl::unexpected(pulse.error());
  const double mass = input.ball.mass_kg;
  const double peak_fraction = pulse->largest_force_fraction();
  const double deepest = pulse->deepest_fraction();
  const double depth_m = -pulse->at_fraction(deepest).y_m;
  const auto of_period = [&](double half_period_s) {
    return mass * std::pow(std::numbers::pi / half_period_s, 2);
  };
  Stiffness out;
  out.half_period = of_period(input.dwell_s);
  out.secant = pulse->at_fraction(peak_fraction).fy_n / depth_m;
  out.energy = mass * std::pow(input.touchdown.vy_mps / depth_m, 2);
  out.compression = of_period(2.0 * deepest * input.dwell_s);
  out.peak_time = of_period(2.0 * peak_fraction * input.dwell_s);
  if (const auto spring = impact::normal_spring(mass, input.e, input.dwell_s)) {
    out.kelvin_voigt = spring->stiffness_npm;
    out.kelvin_voigt_zeta = spring->damping_ratio;
    out.kelvin_voigt_damping = spring->damping_nspm;
  }
  return out;
}

}  // namespace strobe::contact
