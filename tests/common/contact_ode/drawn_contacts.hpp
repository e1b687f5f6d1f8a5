// Contacts drawn over the whole range of inputs, and what their errors are measured by. Deterministic from the seed.
#pragma once

#include <random>
#include <string>

#include "tests/common/contact_ode/reference.hpp"

namespace strobe::testing {

struct ContactCase {
  impact::Motion touchdown;
  impact::ContactCoefficients coefficients;
};

class ContactDraws {
 public:
  explicit ContactDraws(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double over_decades(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random_) == 1; }

 private:
  std::mt19937_64 random_;
};

/// Angle .01 to 90 degrees, speed 1e-6 to 1e3 m/s, |omega| 0 to 1e5 rad/s, e .14 to 1, mu 0 to 10, dwell time
/// 1 us to 1 s; a third with a spin of the order of rolling, where grip and slip change most.
ContactCase draw_contact(ContactDraws& draws);

/// The weight along an inclined plate, or many times it, either way.
void put_weight_along(ContactCase& c, ContactDraws& draws);

std::string text_of(const ContactCase& c);

/// The ball of all of them.
ball::Ball contact_ball();

ReferenceContact reference_of(const ContactCase& c, int intervals);

double relative(const Quad& got, const Quad& expected, double scale);

/// Scale of the changes of the tangential motion: friction's impulse, or what stops the slip where that is less, the
/// offset's couple and the weight along the surface.
double tangential_scale(const ContactCase& c);

/// What the last bits of the motion itself amount to.
double rounding_of(const ContactCase& c);

/// Largest error of lift-off and dwell time against the reference; the tangential ones over their scale, in which
/// what the motion's last bits amount to counts as the tolerance.
double lift_off_error(const ContactCase& c, const impact::Motion& lift_off, double dwell_s,
                      const ReferenceContact& reference, double tolerance);

}  // namespace strobe::testing
