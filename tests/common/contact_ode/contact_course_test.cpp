// Lift-off and motion at a few instants: against the integrator's trajectory.
#include "common/impact/ode/contact_trajectory.hpp"

#include <algorithm>
#include <cmath>

#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using impact::ContactMethod;

namespace {

impact::ContactOptions options_of(ContactMethod method, double tolerance) {
  return {.method = method, .tolerance = tolerance};
}

}  // namespace

TEST_GROUP(ContactCourse){};

// Tangential errors are relative to the changes of that motion; what the last bits of the motion itself, and of the
// reference to 1e-12, amount to comes in addition.
TEST(ContactCourse, EveryInstantKeepsTheTolerance) {
  ContactDraws draws(17);
  int by_collocation = 0;
  for (int i = 0; i < repetitions(120); ++i) {
    const ContactCase c = draw_contact(draws);
    const auto exact = impact::ContactTrajectory::make(contact_ball(), c.touchdown, c.coefficients,
                                                       options_of(ContactMethod::dormand_prince, 1e-12));
    const double radius = contact_ball().radius_m(), normal = -c.touchdown.vy_mps;
    for (const double tolerance : {1e-4, 1e-9}) {
      const auto got = impact::ContactCourse::make(contact_ball(), c.touchdown, c.coefficients,
                                                   options_of(ContactMethod::collocation, tolerance));
      CHECK_TEXT(exact.has_value() && got.has_value(), text_of(c).c_str());
      if (got->lift_off().method == ContactMethod::collocation) ++by_collocation;
      const double dwell = got->lift_off().dwell_s;
      const double speed = tolerance * tangential_scale(c) + 1e-11 * tangential_scale(c) + rounding_of(c);
      for (const double share : {0.0, 0.02, 0.2, 0.4, 0.6, 0.8, 0.98, 1.0}) {
        const impact::ContactState want = exact->at(share * dwell);
        const impact::ContactMotion at = got->at(share * dwell);
        DOUBLES_EQUAL_TEXT(want.vx_mps, at.velocity.vx_mps, speed, text_of(c).c_str());
        DOUBLES_EQUAL_TEXT(want.vy_mps, at.velocity.vy_mps, (tolerance + 1e-11) * normal, text_of(c).c_str());
        DOUBLES_EQUAL_TEXT(radius * want.omega_radps, radius * at.velocity.omega_radps, speed,
                           text_of(c).c_str());
        DOUBLES_EQUAL_TEXT(want.x_m, at.x_m, speed * dwell + 1e-12 * std::abs(want.x_m), text_of(c).c_str());
        DOUBLES_EQUAL_TEXT(want.y_m, at.y_m, (tolerance + 1e-11) * normal * dwell, text_of(c).c_str());
        DOUBLES_EQUAL_TEXT(radius * want.rotation_rad, radius * at.rotation_rad,
                           speed * dwell + 1e-12 * radius * std::abs(want.rotation_rad), text_of(c).c_str());
      }
    }
  }
  CHECK(by_collocation > repetitions(120));
}

TEST(ContactCourse, ItsLiftOffIsThatOfLiftOffAndTheEndOfTheCourse) {
  ContactDraws draws(18);
  for (int i = 0; i < repetitions(200); ++i) {
    const ContactCase c = draw_contact(draws);
    const auto course = impact::ContactCourse::make(contact_ball(), c.touchdown, c.coefficients);
    const auto alone = impact::lift_off(contact_ball(), c.touchdown, c.coefficients);
    CHECK_TEXT(course->lift_off().method == alone->method, text_of(c).c_str());
    DOUBLES_EQUAL(alone->lift_off.vx_mps, course->lift_off().lift_off.vx_mps, 0.0);
    DOUBLES_EQUAL(alone->lift_off.omega_radps, course->lift_off().lift_off.omega_radps, 0.0);
    DOUBLES_EQUAL(alone->dwell_s, course->lift_off().dwell_s, 0.0);
    const impact::ContactMotion start = course->at(0.0);
    DOUBLES_EQUAL(c.touchdown.vx_mps, start.velocity.vx_mps, 4e-16 * std::abs(c.touchdown.vx_mps));
    DOUBLES_EQUAL(0.0, start.x_m, 1e-60);
    DOUBLES_EQUAL(0.0, start.y_m, 1e-60);
  }
}

TEST(ContactCourse, ByTheIntegratorItIsTheTrajectory) {
  const impact::ContactOptions by_name = options_of(ContactMethod::dormand_prince, 1e-9);
  const impact::Motion shot{15.0, -8.0, 20.0};
  const auto course = impact::ContactCourse::make(contact_ball(), shot, {}, by_name);
  const auto trajectory = impact::ContactTrajectory::make(contact_ball(), shot, {}, by_name);
  CHECK_TRUE(course->lift_off().method == ContactMethod::dormand_prince);
  for (const double time_s : {0.0, 1e-3, 2.5e-3, 4.9e-3, 1.0}) {
    DOUBLES_EQUAL(trajectory->at(time_s).x_m, course->at(time_s).x_m, 0.0);
    DOUBLES_EQUAL(trajectory->at(time_s).omega_radps, course->at(time_s).velocity.omega_radps, 0.0);
  }
}

TEST(ContactCourse, WhereCollocationGivesUpTheIntegratorsCourseIsGivenAndTold) {
  const impact::ContactCoefficients stiff{.stiffness_ratio = 1e3, .damping_ratio = 10.0};
  const auto course = impact::ContactCourse::make(contact_ball(), {5.0, -8.0, -100.0}, stiff);
  CHECK_TRUE(course->lift_off().method == ContactMethod::dormand_prince);
  DOUBLES_EQUAL(course->lift_off().lift_off.vx_mps, course->at(1.0).velocity.vx_mps, 1e-9);
}

TEST(ContactCourse, WhatIsOutOfRangeIsNamed) {
  CHECK_TRUE(impact::ContactCourse::make(contact_ball(), {5.0, 8.0, 0.0}, {}).error() ==
             impact::InputError::not_approaching);
  CHECK_TRUE(impact::ContactCourse::make(contact_ball(), {5.0, -8.0, 0.0}, {},
                                         options_of(ContactMethod::collocation, 1e-14))
                 .error() == impact::InputError::tolerance_out_of_range);
}
