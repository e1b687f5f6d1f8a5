// What holds of every contact: energy never grows, a mirrored contact is the mirror image, every contact
// ends. Failing cases print the configuration that repeats them (RC_PARAMS).
#include <rapidcheck.h>

#include <cmath>
#include <numbers>

#include "common/impact/ode/contact_trajectory.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;

namespace {

double fraction() { return *rc::gen::inRange(0, 1'000'001) / 1e6; }
double between(double low, double high) { return low + (high - low) * fraction(); }
double over_decades(double low, double high) { return low * std::pow(high / low, fraction()); }

const ball::Ball kPropertiesBall{.alpha = 0.579};

ContactMethod any_accurate_method() {
  return *rc::gen::element(ContactMethod::collocation, ContactMethod::dormand_prince);
}

Motion any_touchdown() {
  const double degree = std::numbers::pi / 180.0, speed = over_decades(1e-6, 1e3);
  const double angle = *rc::gen::arbitrary<bool>() ? over_decades(0.01, 90.0) : between(1.0, 90.0);
  const double side = *rc::gen::arbitrary<bool>() ? 1.0 : -1.0;
  Motion m{side * speed * std::cos(angle * degree), -speed * std::sin(angle * degree), 0.0};
  switch (*rc::gen::inRange(0, 4)) {
    case 0:
      break;
    case 1:  // rolling, to the last bit or nearly
      m.omega_radps = -m.vx_mps / kPropertiesBall.radius_m();
      break;
    case 2:
      m.omega_radps = between(-3.0, 3.0) * speed / kPropertiesBall.radius_m();
      break;
    default:
      m.omega_radps = between(-1e5, 1e5);
  }
  m.omega_radps = std::clamp(m.omega_radps, -1e5, 1e5);
  return m;
}

/// From nothing to much of everything, with the exact zeros and ones at which laws change.
ContactCoefficients any_coefficients() {
  const auto sometimes = [](double special, double otherwise) {
    return *rc::gen::inRange(0, 6) == 0 ? special : otherwise;
  };
  ContactCoefficients c;
  c.e = sometimes(1.0, between(0.05, 1.0));
  c.dwell_s = over_decades(1e-6, 1.0);
  c.mu = sometimes(0.0, over_decades(1e-3, 10.0));
  c.stiffness_ratio = over_decades(0.05, 20.0);
  c.damping_ratio = sometimes(0.0, over_decades(0.05, 5.0));
  c.offset_share = sometimes(0.0, between(0.0, 1.0));
  c.offset_reference_mps = over_decades(1e-3, 1e3);
  c.gravity_along_mps2 = sometimes(9.8, 0.0) * between(-1.0, 1.0);
  return c;
}

}  // namespace

TEST_GROUP(ContactProperties){};

// Between any two of the asked times the energy may differ by what the integration's
// tolerance and the rounding of the energies themselves allow, and no more. Losses only grow.
TEST(ContactProperties, EnergyNeverGrows) {
  const bool held = rc::check("energy never grows", [] {
    const Motion touchdown = any_touchdown();
    const ContactCoefficients c = any_coefficients();
    const auto contact = ContactTrajectory::make(kPropertiesBall, touchdown, c,
                                                 {.method = any_accurate_method(), .tolerance = 1e-9});
    RC_ASSERT(contact.has_value());
    const double normal = 0.5 * kPropertiesBall.mass_kg * touchdown.vy_mps * touchdown.vy_mps;
    const ContactEnergy& energy = contact->summary().energy;
    // Tangential errors weigh with the speeds that they change.
    const double turning = std::abs(kPropertiesBall.radius_m() * touchdown.omega_radps);
    const double pulled = std::abs(c.gravity_along_mps2) * contact->summary().dwell_s;
    const double moving = std::abs(touchdown.vx_mps) + turning - touchdown.vy_mps + pulled;
    const double allowed =
        1e-9 * kPropertiesBall.mass_kg * (pulled - touchdown.vy_mps) * moving * (1.0 + c.mu) + 1e-9 * normal +
        8e-16 * energy.kinetic_td_j;
    ContactState before = contact->at(0.0);
    for (int i = 0; i <= 200; ++i) {
      const ContactState now = contact->at(contact->summary().dwell_s * i / 200.0);
      RC_ASSERT(now.mechanical_energy_j <= before.mechanical_energy_j + allowed);
      RC_ASSERT(now.dissipated_j >= before.dissipated_j - allowed);
      before = now;
    }
    // Collocation's sums over its nodes are good to 1e-8 (contact_ode.hpp).
    const double sums = contact->summary().method == ContactMethod::collocation ? 10.0 : 1.0;
    RC_ASSERT(std::abs(energy.kinetic_lost_j - energy.dissipated_j()) <= sums * allowed);
  });
  CHECK(held);
}

TEST(ContactProperties, AMirroredContactIsTheMirrorImageToTheLastBit) {
  const bool held = rc::check("mirror", [] {
    const Motion touchdown = any_touchdown();
    const ContactCoefficients c = any_coefficients();
    ContactCoefficients mirrored = c;
    mirrored.gravity_along_mps2 *= -1.0;
    const ContactOptions options{.method = any_accurate_method()};
    const auto one = simulate(kPropertiesBall, touchdown, c, options);
    const auto other = simulate(
        kPropertiesBall, {-touchdown.vx_mps, touchdown.vy_mps, -touchdown.omega_radps}, mirrored, options);
    RC_ASSERT(one.has_value() && other.has_value());
    RC_ASSERT(one->lift_off.vx_mps == -other->lift_off.vx_mps);
    RC_ASSERT(one->lift_off.vy_mps == other->lift_off.vy_mps);
    RC_ASSERT(one->lift_off.omega_radps == -other->lift_off.omega_radps);
    RC_ASSERT(one->dwell_distance_m == -other->dwell_distance_m);
    RC_ASSERT(one->mean_offset_m == -other->mean_offset_m);
    RC_ASSERT(one->event_count == other->event_count);
    RC_ASSERT(one->energy.sliding_j == other->energy.sliding_j);
  });
  CHECK(held);
}

TEST(ContactProperties, EveryContactEndsAfterItsDwellTimeWithFewSteps) {
  const bool held = rc::check("ends", [] {
    const Motion touchdown = any_touchdown();
    ContactCoefficients c = any_coefficients();
    // Far below |vy| the offset is dry friction, as stiff as it is dry.
    c.offset_reference_mps = std::max(c.offset_reference_mps, 1.0);
    const auto s =
        simulate(kPropertiesBall, touchdown, c, {.method = any_accurate_method(), .tolerance = 1e-9});
    RC_ASSERT(s.has_value());
    RC_ASSERT(std::abs(s->dwell_s / c.dwell_s - 1.0) < 1e-8);
    RC_ASSERT(std::abs(s->lift_off.vy_mps / (-c.e * touchdown.vy_mps) - 1.0) < 1e-9 / c.e);
    RC_ASSERT(s->steps < 5000);
    // Where rounding cannot tell grip from slip a step of 1e-7 of the contact holds what no friction could. Collocation takes
    // the weight's fall in closed form; of 25,000 drawn the integrator's steps lost up to 4e-8 of a long one.
    const double fall = c.gravity_along_mps2 * s->dwell_s / (s->lift_off.vy_mps - touchdown.vy_mps);
    const double lost = s->method == ContactMethod::collocation ? 1e-14 : 2e-7;
    RC_ASSERT(std::abs(s->impulse_ratio + fall) <= c.mu * (1.0 + 1e-8) + 1e-7 + lost * std::abs(fall));
  });
  CHECK(held);
}
