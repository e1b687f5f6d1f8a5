// The lift-off's derivatives: against differences of the integrator, as mirror images, by the sum rules that the units
// of the inputs make, and where the integrator takes over.
#include "common/impact/ode/contact_sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <string>

#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using impact::ContactInput;
using impact::ContactOutput;
using impact::ContactSensitivity;

namespace {

/// A contact and its ball, whose inputs can be changed one by one.
struct SensitivityCase {
  ContactCase contact;
  ball::Ball ball = contact_ball();

  double& input(std::size_t k) {
    impact::Motion& m = contact.touchdown;
    impact::ContactCoefficients& c = contact.coefficients;
    double* const all[] = {&m.vx_mps,          &m.vy_mps,
                           &m.omega_radps,     &c.e,
                           &c.dwell_s,         &c.mu,
                           &c.stiffness_ratio, &c.damping_ratio,
                           &c.offset_share,    &c.offset_reference_mps,
                           &c.gravity_mps2,    &c.gravity_along_mps2,
                           &ball.diameter_m,   &ball.alpha};
    return *all[k];
  }
  ContactSensitivity sensitivity(double tolerance) const {
    const auto got = impact::lift_off_with_sensitivity(
        ball, contact.touchdown, contact.coefficients,
        {.method = impact::ContactMethod::collocation, .tolerance = tolerance});
    CHECK_TEXT(got.has_value(), text_of(contact).c_str());
    return *got;
  }
  std::array<double, impact::kContactOutputs> lift_off() const {
    const auto s = impact::lift_off(ball, contact.touchdown, contact.coefficients,
                                    {.method = impact::ContactMethod::dormand_prince, .tolerance = 1e-12});
    CHECK_TEXT(s.has_value(), text_of(contact).c_str());
    return {s->lift_off.vx_mps, s->lift_off.vy_mps,  s->lift_off.omega_radps,
            s->dwell_s,         s->dwell_distance_m, s->rotation_rad};
  }
  /// What a change of the outputs is measured by.
  std::array<double, impact::kContactOutputs> scales() const {
    const double radius = ball.radius_m(), dwell_s = contact.coefficients.dwell_s;
    const double speed = std::hypot(contact.touchdown.vx_mps, contact.touchdown.vy_mps) +
                         radius * std::abs(contact.touchdown.omega_radps);
    return {speed, speed, speed / radius, dwell_s, speed * dwell_s, speed * dwell_s / radius};
  }
};

/// Of shots, a quarter without a tangential dashpot, half with a weight.
SensitivityCase shot_of(ContactDraws& draws, int i) {
  SensitivityCase out;
  const double speed = draws.between(5.0, 30.0), angle = draws.between(0.2, 1.4);
  out.contact.touchdown = {speed * std::cos(angle), -speed * std::sin(angle), draws.between(-300.0, 300.0)};
  impact::ContactCoefficients& c = out.contact.coefficients;
  c.e = draws.between(0.3, 0.95);
  c.mu = draws.between(0.2, 0.9);
  c.stiffness_ratio = draws.between(0.5, 3.0);
  c.damping_ratio = i % 4 == 0 ? 0.0 : draws.between(0.1, 1.5);
  if (i % 2 == 0) {
    c.gravity_mps2 = draws.between(1.0, 50.0);
    c.gravity_along_mps2 = draws.between(-50.0, 50.0);
  }
  return out;
}

/// Half from the whole range of inputs, half with one of them where numbers are hard; a third with a weight along the
/// surface, a quarter with one towards it.
SensitivityCase hard_case(ContactDraws& draws, int i) {
  SensitivityCase out;
  ContactCase& drawn = out.contact;
  drawn = draw_contact(draws);
  impact::ContactCoefficients& c = drawn.coefficients;
  if (i % 2 == 0) {
    const double speed = draws.over_decades(1.0, 60.0), angle = draws.between(0.1, 1.5);
    const double radius = contact_ball().radius_m();
    drawn.touchdown = {speed * std::cos(angle), -speed * std::sin(angle),
                       draws.between(-1.5, 1.5) * speed / radius};
    c.dwell_s = draws.over_decades(1e-3, 1e-2);
    switch (i / 2 % 6) {
      case 0:
        c.stiffness_ratio = draws.over_decades(10.0, 300.0);
        break;
      case 1:
        c.damping_ratio = draws.between(3.0, 10.0);
        break;
      case 2:
        c.mu = draws.between(0.0, 2.0);
        break;
      case 3:
        c.offset_reference_mps = draws.over_decades(0.01, 50.0);
        break;
      case 4:  // dashpots that hold the ball with nearly all the friction there is
        c.damping_ratio = draws.between(0.1, 1.0);
        drawn.touchdown.omega_radps =
            (-drawn.touchdown.vx_mps + draws.between(0.5, 1.1) * c.mu * -drawn.touchdown.vy_mps) / radius;
        break;
      default:
        drawn.touchdown.vx_mps *= draws.over_decades(1e-4, 1.0);
    }
  }
  if (i % 3 == 1) put_weight_along(drawn, draws);
  if (i % 4 == 1) {
    c.e = std::min(c.e, 0.95);
    c.gravity_mps2 = std::min(1e3, 0.02 * draws.between(0.0, 1.0) * -drawn.touchdown.vy_mps / c.dwell_s);
  }
  return out;
}

/// What a change of each input is measured by.
std::array<double, impact::kContactInputs> input_scales(SensitivityCase at) {
  std::array<double, impact::kContactInputs> scale{};
  for (std::size_t k = 0; k < scale.size(); ++k) scale[k] = std::abs(at.input(k));
  const impact::ContactCoefficients& c = at.contact.coefficients;
  const double speed = -at.contact.touchdown.vy_mps;
  const auto set = [&scale](ContactInput input, double value) {
    scale[static_cast<std::size_t>(input)] = value;
  };
  set(ContactInput::vx_mps, speed);
  set(ContactInput::omega_radps, speed / at.ball.radius_m());
  set(ContactInput::gravity_mps2, speed / c.dwell_s);
  set(ContactInput::gravity_along_mps2, speed / c.dwell_s);
  set(ContactInput::mu, std::max(c.mu, 0.1));
  set(ContactInput::damping_ratio, std::max(c.damping_ratio, 0.1));
  set(ContactInput::offset_share, c.offset_share > 0.0 ? c.offset_share : 0.1);
  return scale;
}

using ReferenceDerivative = std::array<std::array<double, impact::kContactInputs>, impact::kContactOutputs>;

/// Not with respect to a dashpot where there is none: NaN.
ReferenceDerivative reference_derivative(const SensitivityCase& at, int intervals) {
  ReferenceInput<Fifty> base(at.ball, at.contact.touchdown, at.contact.coefficients);
  // With an offset the reference's mesh has the instants when the footprint is full.
  if (base.offset_share == 0) base.offset_share = Fifty(1e-30);
  const ReferenceRelease<Fifty> here = reference_release(base, intervals);
  const auto scale = input_scales(at);
  ReferenceDerivative out{};
  for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
    ReferenceInput<Fifty> in = base;
    Fifty* const all[] = {&in.vx_mps,          &in.vy_mps,
                          &in.omega_radps,     &in.e,
                          &in.dwell_s,         &in.mu,
                          &in.stiffness_ratio, &in.damping_ratio,
                          &in.offset_share,    &in.offset_reference_mps,
                          &in.gravity_mps2,    &in.gravity_along_mps2,
                          &in.diameter_m,      &in.alpha};
    const Fifty h = Fifty(static_cast<ContactInput>(k) == ContactInput::e ? -1e-20 : 1e-20) * scale[k];
    *all[k] += h;
    const bool without = static_cast<ContactInput>(k) == ContactInput::damping_ratio && in.damping_ratio == h;
    const ReferenceRelease<Fifty> there = without ? here : reference_release(in, intervals);
    const std::array<Fifty, impact::kContactOutputs> change{
        there.vx_mps - here.vx_mps,   there.vy_mps - here.vy_mps, there.omega_radps - here.omega_radps,
        there.dwell_s - here.dwell_s, there.x_m - here.x_m,       there.angle_rad - here.angle_rad};
    for (std::size_t o = 0; o < impact::kContactOutputs; ++o)
      out[o][k] = without ? std::nan("") : static_cast<double>(change[o] / h);
  }
  return out;
}

/// The largest of all derivatives, in the scales of outputs and inputs.
double derivative_error(const SensitivityCase& at, const ContactSensitivity& got,
                        const ReferenceDerivative& exact, double tolerance) {
  const double radius = at.ball.radius_m(), dwell_s = at.contact.coefficients.dwell_s;
  const double change = tangential_scale(at.contact) + rounding_of(at.contact) / tolerance;
  const std::array<double, impact::kContactOutputs> of_output{change,           -at.contact.touchdown.vy_mps,
                                                              change / radius,  dwell_s,
                                                              change * dwell_s, change * dwell_s / radius};
  const auto scale = input_scales(at);
  double worst = 0.0;
  for (std::size_t o = 0; o < impact::kContactOutputs; ++o)
    for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
      if (std::isnan(exact[o][k])) continue;
      const double whole = of_output[o] + std::abs(exact[o][k]) * scale[k];
      worst = std::max(worst, std::abs(got.derivative[o][k] - exact[o][k]) * scale[k] / whole);
    }
  return worst;
}

}  // namespace

TEST_GROUP(ContactSensitivity){};

// Differences over steps of h = 1e-4 of an input, of fourth order: h⁴ of the function and 1e-12/h of rounding leave 1e-8 of
// the outputs' scales.
TEST(ContactSensitivity, DerivativesAreThoseThatDifferencesOfTheIntegratorHave) {
  ContactDraws draws(5);
  for (int i = 0; i < repetitions(40); ++i) {
    const SensitivityCase shot = shot_of(draws, i);
    const ContactSensitivity got = shot.sensitivity(1e-9);
    CHECK_TRUE(got.contact.method == impact::ContactMethod::collocation);
    CHECK_TRUE(got.kink == impact::ContactKink::none);
    for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
      SensitivityCase moved = shot;
      const double value = moved.input(k), h = 1e-4 * std::abs(value);
      if (h == 0.0) continue;
      const auto at = [&](double step) {
        moved.input(k) = value + step;
        return moved.lift_off();
      };
      const auto one = at(h), back = at(-h), two = at(2.0 * h), far_back = at(-2.0 * h);
      const auto scale = shot.scales();
      for (std::size_t o = 0; o < impact::kContactOutputs; ++o) {
        const double expected = (8.0 * (one[o] - back[o]) - (two[o] - far_back[o])) / (12.0 * h);
        const std::string text = std::string(name(static_cast<ContactOutput>(o))) + " by " +
                                 std::string(name(static_cast<ContactInput>(k))) + ": " +
                                 text_of(shot.contact);
        DOUBLES_EQUAL_TEXT(expected, got.derivative[o][k], 1e-8 * scale[o] / std::abs(value), text.c_str());
      }
    }
  }
}

TEST(ContactSensitivity, TheContactIsThatOfLiftOff) {
  ContactDraws draws(6);
  for (int i = 0; i < repetitions(100); ++i) {
    const ContactCase c = draw_contact(draws);
    const impact::ContactOptions options{.method = impact::ContactMethod::collocation, .tolerance = 1e-9};
    const auto got = impact::lift_off_with_sensitivity(contact_ball(), c.touchdown, c.coefficients, options);
    const auto expected = impact::lift_off(contact_ball(), c.touchdown, c.coefficients, options);
    CHECK_TEXT(got.has_value() && expected.has_value(), text_of(c).c_str());
    CHECK_TRUE(got->contact.regime == expected->regime);
    const double scale = 2e-9 * (tangential_scale(c) + 1e9 * rounding_of(c));
    DOUBLES_EQUAL_TEXT(expected->lift_off.vx_mps, got->contact.lift_off.vx_mps, scale, text_of(c).c_str());
    DOUBLES_EQUAL(expected->lift_off.vy_mps, got->contact.lift_off.vy_mps,
                  1e-12 * std::abs(c.touchdown.vy_mps));
  }
}

// Differences of contacts of 50 digits over 1e-20 of an input's scale have 20 digits and need no second side. By the
// tolerance, with what the outputs change by, or would with the input, as their scales: 0.92 of it in 48 contacts.
TEST(ContactSensitivity, KeepsItsToleranceAgainst50DigitsOverTheWholeRangeAndWhereNumbersAreHard) {
  const char* asked = std::getenv("STROBE_CONTACT_DRAWS");
  const int count = asked ? std::atoi(asked) : repetitions(5);
  ContactDraws draws(20261126);
  std::array<double, 4> worst{};
  int differences = 0;
  for (int i = 0; i < count; ++i) {
    const SensitivityCase drawn = hard_case(draws, i);
    const ReferenceDerivative exact = reference_derivative(drawn, 120);
    std::optional<ReferenceDerivative> finer;
    for (std::size_t k = 0; k < worst.size(); ++k) {
      const double tolerance = std::pow(1e-3, static_cast<double>(k + 1));
      const ContactSensitivity got = drawn.sensitivity(tolerance);
      if (got.contact.method != impact::ContactMethod::collocation) {
        ++differences;
        continue;
      }
      double error = derivative_error(drawn, got, exact, tolerance) / tolerance;
      // The reference's even mesh is coarse for an offset that turns round within a small part of the contact.
      if (error > 1.0) {
        if (!finer) finer = reference_derivative(drawn, 800);
        error = derivative_error(drawn, got, *finer, tolerance) / tolerance;
      }
      worst[k] = std::max(worst[k], error);
      CHECK_TEXT(error <= 2.0,
                 (std::to_string(error) + " of " + std::to_string(tolerance) + ": " + text_of(drawn.contact))
                     .c_str());
    }
  }
  UT_PRINT(("worst " + std::to_string(worst[0]) + " of 1e-3, " + std::to_string(worst[1]) + " of 1e-6, " +
            std::to_string(worst[2]) + " of 1e-9, " + std::to_string(worst[3]) +
            " of 1e-12; the integrator took over " + std::to_string(differences) + " of " +
            std::to_string(4 * count))
               .c_str());
  CHECK(differences <= count / 2 + 3);
}

// What changes sign with the mirror has derivatives of the opposite sign with respect to what does not.
TEST(ContactSensitivity, AMirroredContactHasMirroredDerivativesToTheLastBit) {
  const auto odd_input = [](std::size_t k) {
    const auto input = static_cast<ContactInput>(k);
    return input == ContactInput::vx_mps || input == ContactInput::omega_radps ||
           input == ContactInput::gravity_along_mps2;
  };
  const auto odd_output = [](std::size_t o) {
    const auto output = static_cast<ContactOutput>(o);
    return output != ContactOutput::vy_mps && output != ContactOutput::dwell_s;
  };
  ContactDraws draws(7);
  for (int i = 0; i < repetitions(100); ++i) {
    SensitivityCase one = shot_of(draws, i);
    if (i % 3 == 0) one.contact = draw_contact(draws);
    SensitivityCase other = one;
    for (std::size_t k = 0; k < impact::kContactInputs; ++k)
      if (odd_input(k)) other.input(k) = -other.input(k);
    const ContactSensitivity a = one.sensitivity(1e-6), b = other.sensitivity(1e-6);
    for (std::size_t o = 0; o < impact::kContactOutputs; ++o)
      for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
        const double sign = odd_input(k) == odd_output(o) ? 1.0 : -1.0;
        DOUBLES_EQUAL_TEXT(a.derivative[o][k], sign * b.derivative[o][k], 0.0, text_of(one.contact).c_str());
      }
  }
}

// A change of the unit of length or of time changes no contact: each output of dimension L^a·T^b has the sum of x·df/dx
// over the inputs, weighted with their own exponents of L, equal to a times itself, and likewise for T.
TEST(ContactSensitivity, UnitsOfLengthAndTimeMakeSumRules) {
  // vx vy omega e dwell mu kt ct share w0 g g_x diameter alpha; vx vy omega dwell distance rotation.
  constexpr std::array<double, 14> length{1, 1, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 0};
  constexpr std::array<double, 14> time{-1, -1, -1, 0, 1, 0, 0, 0, 0, -1, -2, -2, 0, 0};
  constexpr std::array<double, 6> of_length{1, 1, 0, 0, 1, 0}, of_time{-1, -1, -1, 1, 0, 0};
  ContactDraws draws(8);
  for (int i = 0; i < repetitions(200); ++i) {
    SensitivityCase shot = shot_of(draws, i);
    if (i % 3 == 0) shot.contact = draw_contact(draws);
    const ContactSensitivity s = shot.sensitivity(1e-6);
    if (s.contact.method != impact::ContactMethod::collocation) continue;
    const impact::ContactLiftOff& at = s.contact;
    const std::array<double, 6> value{at.lift_off.vx_mps, at.lift_off.vy_mps,  at.lift_off.omega_radps,
                                      at.dwell_s,         at.dwell_distance_m, at.rotation_rad};
    for (std::size_t o = 0; o < impact::kContactOutputs; ++o) {
      double by_length = 0.0, by_time = 0.0, size = std::abs(value[o]);
      for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
        const double term = shot.input(k) * s.derivative[o][k];
        by_length += length[k] * term;
        by_time += time[k] * term;
        size = std::max(size, std::abs(term));
      }
      DOUBLES_EQUAL_TEXT(of_length[o] * value[o], by_length, 1e-11 * size, text_of(shot.contact).c_str());
      DOUBLES_EQUAL_TEXT(of_time[o] * value[o], by_time, 1e-11 * size, text_of(shot.contact).c_str());
    }
  }
}

// Without friction and offset only the normal motion and the flight along the surface are left.
TEST(ContactSensitivity, WithoutFrictionItIsThatOfTheNormalMotion) {
  const impact::Motion touchdown{12.0, -7.0, 40.0};
  const impact::ContactCoefficients c{.e = 0.8, .mu = 0.0, .offset_share = 0.0};
  const auto s = impact::lift_off_with_sensitivity(
      contact_ball(), touchdown, c, {.method = impact::ContactMethod::collocation, .tolerance = 1e-12});
  CHECK_TRUE(s.has_value());
  using enum ContactInput;
  DOUBLES_EQUAL(1.0, s->of(ContactOutput::vx_mps, vx_mps), 1e-15);
  DOUBLES_EQUAL(-0.8, s->of(ContactOutput::vy_mps, vy_mps), 1e-12);
  DOUBLES_EQUAL(7.0, s->of(ContactOutput::vy_mps, e), 1e-11);
  DOUBLES_EQUAL(1.0, s->of(ContactOutput::dwell_s, dwell_s), 1e-14);
  DOUBLES_EQUAL(0.0, s->of(ContactOutput::dwell_s, e), 1e-17);
  DOUBLES_EQUAL(12.0, s->of(ContactOutput::dwell_distance_m, dwell_s), 1e-12);
  DOUBLES_EQUAL(c.dwell_s, s->of(ContactOutput::rotation_rad, omega_radps), 1e-17);
  // A first bit of friction takes mu·J from vx, forward as the contact point slips.
  DOUBLES_EQUAL(-7.0 * 1.8, s->of(ContactOutput::vx_mps, mu), 1e-11);
}

TEST(ContactSensitivity, WhereTheIntegratorTakesOverItsDifferencesAreGivenAndTold) {
  SensitivityCase stiff;
  stiff.contact.touchdown = {5.0, -8.0, -100.0};
  stiff.contact.coefficients.stiffness_ratio = 1e3;
  stiff.contact.coefficients.damping_ratio = 10.0;
  const ContactSensitivity got = stiff.sensitivity(1e-9);
  CHECK_TRUE(got.contact.method == impact::ContactMethod::dormand_prince);
  const auto scale = stiff.scales();
  for (const ContactInput input : {ContactInput::vx_mps, ContactInput::mu, ContactInput::dwell_s}) {
    const auto k = static_cast<std::size_t>(input);
    SensitivityCase moved = stiff;
    const double value = moved.input(k), h = 1e-4 * std::abs(value);
    moved.input(k) = value + h;
    const auto one = moved.lift_off();
    moved.input(k) = value - h;
    const auto other = moved.lift_off();
    for (std::size_t o = 0; o < impact::kContactOutputs; ++o)
      DOUBLES_EQUAL((one[o] - other[o]) / (2.0 * h), got.derivative[o][k], 1e-6 * scale[o] / std::abs(value));
  }
}

TEST(ContactSensitivity, WhereEitherSideHasItsOwnDerivativeItIsNamed) {
  SensitivityCase rest;
  rest.contact.touchdown = {0.0, -8.0, 0.0};
  rest.contact.coefficients.mu = 0.0;
  CHECK_TRUE(rest.sensitivity(1e-6).kink == impact::ContactKink::frictionless_rest);
  SensitivityCase drop;
  drop.contact.touchdown = {0.0, -8.0, 30.0};
  drop.contact.coefficients.offset_law = impact::OffsetLaw::constant_ahead;
  CHECK_TRUE(drop.sensitivity(1e-6).kink == impact::ContactKink::offset_turns_round);
}

TEST(ContactSensitivity, NothingIsAllocated) {
  const impact::Motion touchdown{15.0, -8.0, 20.0};
  bool done = false;
  std::int64_t allocated = -1;
  {
    const AllocationCounter counter;
    done = impact::lift_off_with_sensitivity(contact_ball(), touchdown, {}).has_value();
    allocated = counter.count();
  }
  CHECK_TRUE(done);
  LONGS_EQUAL(0, allocated);
}
