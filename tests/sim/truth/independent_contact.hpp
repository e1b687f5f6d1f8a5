// The contact's mechanics once more, in a few lines and by other means than the product's: the normal motion
// in closed form, the tangential one by small steps of a force that is tried and cut off at Coulomb's limit,
// so that there are neither modes nor events. For tests; pure, thread-safe.
#pragma once

#include <vector>

namespace strobe::testing {

struct ContactInput {
  double mass_kg, radius_m, alpha;
  double vx_mps, vy_mps, omega_radps;  ///< at touchdown; vy < 0
  double e, dwell_s;                   ///< touchdown to the centre's return to its height there
  double mu, stiffness_ratio, damping_ratio, offset_share, offset_reference_mps;
};

struct ContactPoint {
  double x_m = 0.0, y_m = 0.0;  ///< of the centre since touchdown; y <= 0
  double rotation_rad = 0.0, vx_mps = 0.0, omega_radps = 0.0;
};

/// The course at equal steps from touchdown (first) to lift-off (last). Errors fall with the square of the
/// number of steps.
std::vector<ContactPoint> contact_course(const ContactInput& input, int steps);

}  // namespace strobe::testing
