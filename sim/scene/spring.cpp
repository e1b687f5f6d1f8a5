#include "sim/scene/spring.hpp"

#include <cmath>

namespace strobe::sim {

SpringRebound rebound_of_spring(double mass_kg, double stiffness_npm, double damping_nspm) {
  const double zeta = damping_nspm / (2.0 * std::sqrt(stiffness_npm * mass_kg));
  return {impact::restitution_of_damping_ratio(zeta),
          (impact::release_phase(zeta) + 2.0 * zeta) * std::sqrt(mass_kg / stiffness_npm)};
}

tl::expected<impact::NormalSpring, impact::InputError> spring_of_rebound(double mass_kg,
                                                                         const SpringRebound& rebound) {
  return impact::damping_ratio_from_restitution(rebound.e).and_then([&](double zeta) {
    const double share = 1.0 + 2.0 * zeta / impact::release_phase(zeta);
    return impact::normal_spring(mass_kg, rebound.e, rebound.dwell_s / share);
  });
}

}  // namespace strobe::sim
