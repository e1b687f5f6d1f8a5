// The contact integrated in doubles against 34 digits, over the whole range of inputs.
#include <algorithm>
#include <cmath>
#include <string>

#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;

TEST_GROUP(ContactReference){};

// Halving the reference's steps changes it by far less than it is used to tell.
TEST(ContactReference, TheReferenceItselfHasConverged) {
  ContactDraws draws(7);
  for (int i = 0; i < 6; ++i) {
    const ContactCase c = draw_contact(draws);
    const auto coarse = reference_of(c, 60);
    const auto fine = reference_of(c, 120);
    const double scale = std::abs(c.touchdown.vx_mps) + std::abs(c.touchdown.vy_mps) +
                         0.03255 * std::abs(c.touchdown.omega_radps);
    DOUBLES_EQUAL(0.0, relative(coarse.vx_mps, fine.vx_mps, scale), 1e-11);
    DOUBLES_EQUAL(0.0, relative(coarse.omega_radps, fine.omega_radps, scale / 0.03255), 1e-11);
  }
}

TEST(ContactReference, AnIntegratorsToleranceOf1e9HoldsNineDigitsOverTheWholeRange) {
  const unsigned seed = 20261121;
  ContactDraws draws(seed);
  double worst = 0.0;
  for (int i = 0; i < repetitions(100); ++i) {
    const ContactCase c = draw_contact(draws);
    const auto got = impact::simulate({.alpha = impact::kContactAlpha}, c.touchdown, c.coefficients,
                                      {.method = impact::ContactMethod::dormand_prince, .tolerance = 1e-9});
    CHECK_TEXT(got.has_value(), text_of(c).c_str());
    const double error = lift_off_error(c, got->lift_off, got->dwell_s, reference_of(c, 200), 1e-9);
    worst = std::max(worst, error);
    CHECK_TEXT(error <= 1e-9,
               (std::to_string(i) + ": " + std::to_string(error * 1e9) + "e-9: " + text_of(c)).c_str());
  }
  UT_PRINT(("worst: " + std::to_string(worst * 1e9) + "e-9, seed " + std::to_string(seed)).c_str());
}

TEST(ContactReference, GripTimesAreThoseOfTheReference) {
  for (const double angle_vy : {-5.0, -8.0, -12.0, -15.0}) {
    const ContactCase c{{15.0, angle_vy, 30.0}, {}};
    const auto reference = reference_of(c, 80);
    for (const auto method : {impact::ContactMethod::collocation, impact::ContactMethod::dormand_prince}) {
      const auto got =
          impact::simulate({.alpha = impact::kContactAlpha}, c.touchdown, c.coefficients, {.method = method});
      CHECK_EQUAL(reference.first_grip_s.has_value(), got->skid_to_grip_s.has_value());
      if (got->skid_to_grip_s)
        DOUBLES_EQUAL(0.0, relative(*got->skid_to_grip_s, *reference.first_grip_s, 5e-3), 1e-8);
    }
  }
}
