// The lift-off's derivatives: against differences of the integrator and of contacts of 50 digits, as mirror images, and
// where the integrator takes over.
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
using impact::ContactSensitivity;

namespace {

using InputValues = std::array<double, impact::kContactInputs>;

/// A contact and its ball, whose inputs can be changed one by one.
struct SensitivityCase {
  ContactCase contact;
  ball::Ball ball = contact_ball();

  /// In the order of ContactInput.
  double& input(std::size_t k) {
    impact::ContactCoefficients& c = contact.coefficients;
    double* const all[] = {&c.dwell_s,      &c.mu,
                           &c.stiffness_ratio, &c.damping_ratio,
                           &c.offset_share, &c.offset_reference_mps,
                           &ball.alpha};
    return *all[k];
  }
  ContactSensitivity sensitivity(double tolerance) const {
    const auto got =
        impact::lift_off_sensitivity(ball, contact.touchdown, contact.coefficients, {.tolerance = tolerance});
    CHECK_TEXT(got.has_value(), text_of(contact).c_str());
    return *got;
  }
  impact::Motion lift_off() const {
    const auto s = impact::lift_off(ball, contact.touchdown, contact.coefficients,
                                    {.method = impact::ContactMethod::dormand_prince, .tolerance = 1e-12});
    CHECK_TEXT(s.has_value(), text_of(contact).c_str());
    return s->lift_off;
  }
  /// What a change of the speeds is measured by.
  double speed_mps() const {
    return std::hypot(contact.touchdown.vx_mps, contact.touchdown.vy_mps) +
           ball.radius_m() * std::abs(contact.touchdown.omega_radps);
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
InputValues input_scales(SensitivityCase at) {
  InputValues scale{};
  for (std::size_t k = 0; k < scale.size(); ++k) scale[k] = std::abs(at.input(k));
  const impact::ContactCoefficients& c = at.contact.coefficients;
  scale[static_cast<std::size_t>(ContactInput::mu)] = std::max(c.mu, 0.1);
  scale[static_cast<std::size_t>(ContactInput::damping_ratio)] = std::max(c.damping_ratio, 0.1);
  return scale;
}

/// Of vx and R·omega, m/s over the input's unit.
struct Derivatives {
  InputValues vx{}, spin{};
};

Derivatives derivatives_of(const SensitivityCase& at, const ContactSensitivity& s) {
  Derivatives out{s.vx_mps, s.omega_radps};
  for (double& value : out.spin) value *= at.ball.radius_m();
  return out;
}

/// Not with respect to a dashpot or an offset where there is none: NaN.
Derivatives reference_derivatives(const SensitivityCase& at, int intervals) {
  ReferenceInput<Fifty> base(at.ball, at.contact.touchdown, at.contact.coefficients);
  // With an offset the reference's mesh has the instants when the footprint is full.
  if (base.offset_share == 0) base.offset_share = Fifty(1e-30);
  const ReferenceRelease<Fifty> here = reference_release(base, intervals);
  const InputValues scale = input_scales(at);
  Derivatives out;
  for (std::size_t k = 0; k < scale.size(); ++k) {
    ReferenceInput<Fifty> in = base;
    Fifty* const all[] = {&in.dwell_s,      &in.mu,
                          &in.stiffness_ratio, &in.damping_ratio,
                          &in.offset_share, &in.offset_reference_mps,
                          &in.alpha};
    const Fifty h = Fifty(1e-20) * scale[k];
    *all[k] += h;
    const bool without = h == 0 || (static_cast<ContactInput>(k) == ContactInput::damping_ratio && in.damping_ratio == h);
    const ReferenceRelease<Fifty> there = without ? here : reference_release(in, intervals);
    out.vx[k] = without ? std::nan("") : static_cast<double>((there.vx_mps - here.vx_mps) / h);
    out.spin[k] = without ? std::nan("")
                          : static_cast<double>(in.diameter_m / 2 * (there.omega_radps - here.omega_radps) / h);
  }
  return out;
}

/// The largest of all derivatives, in the scales of outputs and inputs.
double derivative_error(const SensitivityCase& at, const Derivatives& got, const Derivatives& exact,
                        double tolerance) {
  const double change = tangential_scale(at.contact) + rounding_of(at.contact) / tolerance;
  const InputValues scale = input_scales(at);
  double worst = 0.0;
  for (const InputValues Derivatives::*of : {&Derivatives::vx, &Derivatives::spin})
    for (std::size_t k = 0; k < scale.size(); ++k) {
      const double want = (exact.*of)[k];
      if (std::isnan(want)) continue;
      const double whole = change + std::abs(want) * scale[k];
      worst = std::max(worst, std::abs((got.*of)[k] - want) * scale[k] / whole);
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
    CHECK_TRUE(got.method == impact::ContactMethod::collocation);
    for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
      SensitivityCase moved = shot;
      const double value = moved.input(k), h = 1e-4 * std::abs(value);
      if (h == 0.0) continue;
      const auto at = [&](double step) {
        moved.input(k) = value + step;
        return moved.lift_off();
      };
      const auto one = at(h), back = at(-h), two = at(2.0 * h), far_back = at(-2.0 * h);
      const auto check = [&](double impact::Motion::*speed, double derivative, double scale) {
        const double expected =
            (8.0 * (one.*speed - back.*speed) - (two.*speed - far_back.*speed)) / (12.0 * h);
        const std::string text = "by input " + std::to_string(k) + ": " + text_of(shot.contact);
        DOUBLES_EQUAL_TEXT(expected, derivative, 1e-8 * scale / std::abs(value), text.c_str());
      };
      check(&impact::Motion::vx_mps, got.vx_mps[k], shot.speed_mps());
      check(&impact::Motion::omega_radps, got.omega_radps[k], shot.speed_mps() / shot.ball.radius_m());
    }
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
    const Derivatives exact = reference_derivatives(drawn, 120);
    std::optional<Derivatives> finer;
    for (std::size_t k = 0; k < worst.size(); ++k) {
      const double tolerance = std::pow(1e-3, static_cast<double>(k + 1));
      const ContactSensitivity got = drawn.sensitivity(tolerance);
      if (got.method != impact::ContactMethod::collocation) {
        ++differences;
        continue;
      }
      double error = derivative_error(drawn, derivatives_of(drawn, got), exact, tolerance) / tolerance;
      // The reference's even mesh is coarse for an offset that turns round within a small part of the contact.
      if (error > 1.0) {
        if (!finer) finer = reference_derivatives(drawn, 800);
        error = derivative_error(drawn, derivatives_of(drawn, got), *finer, tolerance) / tolerance;
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

TEST(ContactSensitivity, AMirroredContactHasMirroredDerivativesToTheLastBit) {
  ContactDraws draws(7);
  for (int i = 0; i < repetitions(100); ++i) {
    SensitivityCase one = shot_of(draws, i);
    if (i % 3 == 0) one.contact = draw_contact(draws);
    SensitivityCase other = one;
    for (double* const turned :
         {&other.contact.touchdown.vx_mps, &other.contact.touchdown.omega_radps, &other.contact.coefficients.gravity_along_mps2})
      *turned = -*turned;
    const ContactSensitivity a = one.sensitivity(1e-6), b = other.sensitivity(1e-6);
    for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
      if (std::isnan(a.vx_mps[k])) continue;
      DOUBLES_EQUAL_TEXT(a.vx_mps[k], -b.vx_mps[k], 0.0, text_of(one.contact).c_str());
      DOUBLES_EQUAL_TEXT(a.omega_radps[k], -b.omega_radps[k], 0.0, text_of(one.contact).c_str());
    }
  }
}

// A first bit of friction takes mu·J from vx, forward as the contact point slips.
TEST(ContactSensitivity, WithoutFrictionOnlyAFirstBitOfItCounts) {
  const auto s = impact::lift_off_sensitivity(contact_ball(), {12.0, -7.0, 40.0},
                                              {.e = 0.8, .mu = 0.0, .offset_share = 0.0}, {.tolerance = 1e-12});
  for (std::size_t k = 0; k < impact::kContactInputs; ++k) {
    const auto input = static_cast<ContactInput>(k);
    if (input == ContactInput::offset_share)
      CHECK(std::isnan(s->vx_mps[k]) && std::isnan(s->omega_radps[k]));
    else
      DOUBLES_EQUAL(input == ContactInput::mu ? -7.0 * 1.8 : 0.0, s->vx_mps[k], 1e-11);
  }
}

TEST(ContactSensitivity, WhereTheIntegratorTakesOverItsDifferencesAreGivenAndTold) {
  SensitivityCase stiff;
  stiff.contact.touchdown = {5.0, -8.0, -100.0};
  stiff.contact.coefficients.stiffness_ratio = 1e3;
  stiff.contact.coefficients.damping_ratio = 10.0;
  const ContactSensitivity got = stiff.sensitivity(1e-9);
  CHECK_TRUE(got.method == impact::ContactMethod::dormand_prince);
  for (const ContactInput input : {ContactInput::alpha, ContactInput::mu, ContactInput::dwell_s}) {
    const auto k = static_cast<std::size_t>(input);
    SensitivityCase moved = stiff;
    const double value = moved.input(k), h = 1e-4 * std::abs(value), allowed = 1e-6 * stiff.speed_mps() / std::abs(value);
    moved.input(k) = value + h;
    const impact::Motion one = moved.lift_off();
    moved.input(k) = value - h;
    const impact::Motion other = moved.lift_off();
    DOUBLES_EQUAL((one.vx_mps - other.vx_mps) / (2.0 * h), got.vx_mps[k], allowed);
    DOUBLES_EQUAL((one.omega_radps - other.omega_radps) / (2.0 * h), got.omega_radps[k],
                  allowed / stiff.ball.radius_m());
  }
}

TEST(ContactSensitivity, NothingIsAllocated) {
  bool done = false;
  std::int64_t allocated = -1;
  {
    const AllocationCounter counter;
    done = impact::lift_off_sensitivity(contact_ball(), {15.0, -8.0, 20.0}, {}).has_value();
    allocated = counter.count();
  }
  CHECK_TRUE(done);
  LONGS_EQUAL(0, allocated);
}
