// The contact by collocation: against 34 digits over the whole range of inputs, against the integrator where numbers
// are hard, and what holds of every contact. STROBE_CONTACT_DRAWS=20000 draws more.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>

#include "common/impact/ode/contact_collocation.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "common/impact/ode/segment_solver.hpp"
#include "tests/common/contact_ode/drawn_contacts.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::testing;
using impact::ContactCoefficients;
using impact::ContactMethod;
using impact::Motion;

namespace {

constexpr std::array<double, 4> kTolerances{1e-3, 1e-6, 1e-9, 1e-12};

int draws_of_a_run(int usual) {
  const char* asked = std::getenv("STROBE_CONTACT_DRAWS");
  return asked ? std::atoi(asked) : repetitions(usual);
}

impact::ContactOptions integrator(double tolerance) {
  return {.method = ContactMethod::dormand_prince, .tolerance = tolerance};
}

impact::ContactOptions collocation(double tolerance) {
  return {.method = ContactMethod::collocation, .tolerance = tolerance};
}

/// Spins of the order of rolling, speeds of shots: what a stress set varies from.
ContactCase ordinary(ContactDraws& draws) {
  ContactCase c = draw_contact(draws);
  const double degree = std::numbers::pi / 180.0, speed = draws.over_decades(1.0, 60.0);
  const double angle = draws.between(5.0, 90.0);
  c.touchdown = {speed * std::cos(angle * degree), -speed * std::sin(angle * degree),
                 draws.between(-1.5, 1.5) * speed / contact_ball().radius_m()};
  c.coefficients.dwell_s = draws.over_decades(1e-3, 1e-2);
  return c;
}

struct StressSet {
  const char* name;
  void (*change)(ContactCase&, ContactDraws&);  ///< null: drawn from the whole range
  double fallbacks;                             ///< largest share that the integrator may take over
};

void make_steep_or_shallow(ContactCase& c, ContactDraws& draws) {
  const double degree = std::numbers::pi / 180.0, speed = std::hypot(c.touchdown.vx_mps, c.touchdown.vy_mps);
  const double angle = draws.one_in(2) ? draws.between(85.0, 90.0) : draws.over_decades(0.05, 5.0);
  c.touchdown.vx_mps = speed * std::cos(angle * degree);
  c.touchdown.vy_mps = -speed * std::sin(angle * degree);
}

/// Dashpots that hold the ball at touchdown with nearly all the friction there is: grips that graze their limit.
void make_grazing(ContactCase& c, ContactDraws& draws) {
  c.coefficients.e = draws.between(0.3, 0.9);
  c.coefficients.damping_ratio = draws.between(0.1, 1.0);
  c.coefficients.mu = draws.between(0.2, 1.0);
  const double rolling = -c.touchdown.vx_mps / contact_ball().radius_m();
  c.touchdown.omega_radps =
      rolling + draws.between(0.5, 1.1) * c.coefficients.mu * -c.touchdown.vy_mps / contact_ball().radius_m();
}

const StressSet kStressSets[] = {
    {"the whole range", nullptr, 0.005},
    {"stiff springs",
     [](ContactCase& c, ContactDraws& d) { c.coefficients.stiffness_ratio = d.over_decades(10.0, 300.0); },
     0.1},
    {"dashpots of 0 and 3 to 10",
     [](ContactCase& c, ContactDraws& d) {
       c.coefficients.damping_ratio = d.one_in(4) ? 0.0 : d.between(3.0, 10.0);
     },
     0.1},
    {"e .05 to 1", [](ContactCase& c, ContactDraws& d) { c.coefficients.e = d.between(0.05, 1.0); }, 0.1},
    {"mu 0 to 2",
     [](ContactCase& c, ContactDraws& d) { c.coefficients.mu = d.one_in(10) ? 0.0 : d.between(0.0, 2.0); },
     0.1},
    {"w0 .01 to 50 m/s",
     [](ContactCase& c, ContactDraws& d) {
       c.coefficients.offset_reference_mps = d.over_decades(0.01, 50.0);
       c.coefficients.offset_share = d.between(0.0, 0.3);
     },
     0.1},
    {"grazing grips", make_grazing, 0.1},
    {"steep and shallow", make_steep_or_shallow, 0.02},
    {"weight",
     [](ContactCase& c, ContactDraws& d) {
       c.coefficients.gravity_mps2 = d.one_in(2) ? 9.81 : d.over_decades(0.1, 100.0);
     },
     0.2},
    {"weight along the plate", put_weight_along, 0.15},
    {"constant offset",
     [](ContactCase& c, ContactDraws&) { c.coefficients.offset_law = impact::OffsetLaw::constant_ahead; },
     0.1},
};

}  // namespace

TEST_GROUP(Collocation){};

// The reference costs far more than what it judges: each contact of it judges all four tolerances. Of 2,000 draws the
// integrator took over 1 at most; a hundredth and two are beyond what chance makes of that.
TEST(Collocation, KeepsItsToleranceAgainst34DigitsOverTheWholeRange) {
  const unsigned seed = 20261123;
  const int count = draws_of_a_run(60);
  ContactDraws draws(seed);
  std::array<double, 4> worst{};
  std::array<int, 4> fallbacks{};
  for (int i = 0; i < count; ++i) {
    const ContactCase c = draw_contact(draws);
    const ReferenceContact reference = reference_of(c, 200);
    for (std::size_t k = 0; k < kTolerances.size(); ++k) {
      const double tolerance = kTolerances[k];
      const auto got = impact::lift_off(contact_ball(), c.touchdown, c.coefficients, collocation(tolerance));
      CHECK_TEXT(got.has_value(), text_of(c).c_str());
      if (got->method != ContactMethod::collocation) ++fallbacks[k];
      double error = lift_off_error(c, got->lift_off, got->dwell_s, reference, tolerance) / tolerance;
      // The reference's even mesh is coarse for an offset that turns round within a small part of the contact.
      if (error > 1.0)
        error = lift_off_error(c, got->lift_off, got->dwell_s, reference_of(c, 1200), tolerance) / tolerance;
      worst[k] = std::max(worst[k], error);
      CHECK_TEXT(error <= 1.0, (std::to_string(i) + " at " + std::to_string(tolerance) + ": " +
                                std::to_string(error) + " of it: " + text_of(c))
                                   .c_str());
    }
  }
  for (std::size_t k = 0; k < kTolerances.size(); ++k) {
    UT_PRINT(("tolerance 1e-" + std::to_string(3 * (k + 1)) + ": worst " + std::to_string(worst[k]) +
              " of it, the integrator took over " + std::to_string(fallbacks[k]) + " of " +
              std::to_string(count) + ", seed " + std::to_string(seed))
                 .c_str());
    CHECK(fallbacks[k] <= count / 100 + 2);
  }
}

TEST(Collocation, AWeightAlongThePlateKeepsTheToleranceAgainst34Digits) {
  ContactDraws draws(20261125);
  for (int i = 0; i < draws_of_a_run(20); ++i) {
    ContactCase c = draw_contact(draws);
    put_weight_along(c, draws);
    const ReferenceContact reference = reference_of(c, 200);
    for (const double tolerance : kTolerances) {
      const auto got = impact::lift_off(contact_ball(), c.touchdown, c.coefficients, collocation(tolerance));
      CHECK_TEXT(got.has_value(), text_of(c).c_str());
      double error = lift_off_error(c, got->lift_off, got->dwell_s, reference, tolerance);
      if (error > tolerance)
        error = lift_off_error(c, got->lift_off, got->dwell_s, reference_of(c, 1200), tolerance);
      CHECK_TEXT(error <= tolerance, (std::to_string(error / tolerance) + " of it: " + text_of(c)).c_str());
      const double length = (tangential_scale(c) + rounding_of(c) / tolerance) * c.coefficients.dwell_s;
      DOUBLES_EQUAL_TEXT(static_cast<double>(reference.x_m), got->dwell_distance_m, 2.0 * tolerance * length,
                         text_of(c).c_str());
    }
  }
}

// Judged by the integrator two orders better than the tolerance, but no better than 1e-12.
TEST(Collocation, KeepsItsToleranceWhereNumbersAreHardOrSaysThatTheIntegratorTookOver) {
  for (const StressSet& set : kStressSets) {
    const int count = draws_of_a_run(set.change ? 60 : 740);
    ContactDraws draws(20261124);
    int fallbacks = 0;
    double worst = 0.0;
    for (int i = 0; i < count; ++i) {
      ContactCase c = set.change ? ordinary(draws) : draw_contact(draws);
      if (set.change) set.change(c, draws);
      const auto exact = impact::simulate(contact_ball(), c.touchdown, c.coefficients, integrator(1e-12));
      for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
        const auto got =
            impact::lift_off(contact_ball(), c.touchdown, c.coefficients, collocation(tolerance));
        CHECK_EQUAL(exact.has_value(), got.has_value());
        if (!got) continue;
        if (got->method != ContactMethod::collocation) ++fallbacks;
        const ReferenceContact reference{exact->lift_off.vx_mps,
                                         exact->lift_off.vy_mps,
                                         exact->lift_off.omega_radps,
                                         exact->dwell_s,
                                         exact->dwell_distance_m,
                                         exact->rotation_rad,
                                         std::nullopt,
                                         0};
        const double error = lift_off_error(c, got->lift_off, got->dwell_s, reference, tolerance) / tolerance;
        worst = std::max(worst, error);
        CHECK_TEXT(error <= 1.0, (std::string(set.name) + " " + std::to_string(tolerance) + ": " +
                                  std::to_string(error) + " of it: " + text_of(c))
                                     .c_str());
        CHECK_TRUE(exact->regime == got->regime);
      }
    }
    UT_PRINT((std::string(set.name) + ": worst " + std::to_string(worst) +
              " of the tolerance, the integrator took over " + std::to_string(fallbacks) + " of " +
              std::to_string(3 * count))
                 .c_str());
    // Few are drawn under sanitizers; a contact falls back at all three tolerances or at none.
    const double expected = set.fallbacks * count;
    CHECK_TEXT(fallbacks <= 3.0 * (expected + 3.0 * std::sqrt(expected)), set.name);
  }
}

// The cost of lift_off() is that of its nodes. 1 to 60 m/s, 5 to 85 degrees, |R omega| up to the speed and 600 rad/s, e
// .5 to .9, mu .3 to .9, dwell times of tennis balls. Means of 300 contacts, with a twentieth for other compilers.
TEST(Collocation, BouncesOfShotsTakeFewNodesAndNoIntegrator) {
  ContactDraws draws(1);
  std::array<double, 4> nodes{};
  std::array<int, 4> given_up{};
  constexpr int kContacts = 300;
  for (int i = 0; i < kContacts; ++i) {
    const double degree = std::numbers::pi / 180.0, speed = draws.over_decades(1.0, 60.0);
    const double angle = draws.between(5.0, 85.0), radius = contact_ball().radius_m();
    const Motion touchdown{speed * std::cos(angle * degree), -speed * std::sin(angle * degree),
                           draws.between(-1.0, 1.0) * std::min(600.0, speed / radius)};
    ContactCoefficients c{.e = draws.between(0.5, 0.9), .dwell_s = draws.between(3e-3, 6.5e-3)};
    c.mu = draws.between(0.3, 0.9);
    c.stiffness_ratio = draws.over_decades(0.7, 2.5);
    c.damping_ratio = draws.over_decades(0.2, 1.5);
    c.offset_share = draws.between(0.0, 0.25);
    const auto system = impact::detail::make_system(contact_ball(), touchdown, c);
    const auto constants = impact::detail::CollocationConstants::make(*system);
    for (std::size_t k = 0; k < kTolerances.size(); ++k) {
      const auto contact = impact::detail::collocate(*constants, kTolerances[k], false, nullptr);
      if (!contact) ++given_up[k];
      if (contact) nodes[k] += static_cast<double>(contact->evaluations) / kContacts;
    }
  }
  const std::array<double, 4> most{29.8, 57.2, 80.7, 107.1};
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    UT_PRINT((std::to_string(nodes[k]) + " nodes, given up: " + std::to_string(given_up[k])).c_str());
    CHECK(nodes[k] <= 1.05 * most[k]);
    LONGS_EQUAL(0, given_up[k]);
  }
}

TEST(Collocation, AMirroredContactIsTheMirrorImageToTheLastBit) {
  ContactDraws draws(3);
  for (int i = 0; i < repetitions(300); ++i) {
    ContactCase c = i % 2 == 0 ? draw_contact(draws) : ordinary(draws);
    if (i % 3 == 0) put_weight_along(c, draws);
    const Motion mirrored{-c.touchdown.vx_mps, c.touchdown.vy_mps, -c.touchdown.omega_radps};
    ContactCoefficients mirrored_coefficients = c.coefficients;
    mirrored_coefficients.gravity_along_mps2 *= -1.0;
    const auto one = impact::simulate(contact_ball(), c.touchdown, c.coefficients, collocation(1e-6));
    const auto other = impact::simulate(contact_ball(), mirrored, mirrored_coefficients, collocation(1e-6));
    CHECK_TRUE(one.has_value() && other.has_value());
    CHECK_TRUE(one->method == other->method);
    DOUBLES_EQUAL(-one->lift_off.vx_mps, other->lift_off.vx_mps, 0.0);
    DOUBLES_EQUAL(one->lift_off.vy_mps, other->lift_off.vy_mps, 0.0);
    DOUBLES_EQUAL(-one->lift_off.omega_radps, other->lift_off.omega_radps, 0.0);
    DOUBLES_EQUAL(-one->dwell_distance_m, other->dwell_distance_m, 0.0);
    DOUBLES_EQUAL(-one->rotation_rad, other->rotation_rad, 0.0);
    DOUBLES_EQUAL(one->energy.sliding_j, other->energy.sliding_j, 0.0);
    CHECK_EQUAL(one->event_count, other->event_count);
  }
}

// The sums over the nodes are good to 1e-8 of m·|vy| times the speeds that they change (contact_ode.hpp); the
// mechanical energy at given instants to the tolerance.
TEST(Collocation, EnergyNeverGrowsAndIsAccountedFor) {
  ContactDraws draws(5);
  int by_collocation = 0;
  for (int i = 0; i < repetitions(150); ++i) {
    ContactCase c = i % 2 == 0 ? draw_contact(draws) : ordinary(draws);
    if (i % 3 == 0) put_weight_along(c, draws);
    const ball::Ball ball = contact_ball();
    const auto contact =
        impact::ContactTrajectory::make(ball, c.touchdown, c.coefficients, collocation(1e-9));
    CHECK_TRUE(contact.has_value());
    const impact::ContactSummary& summary = contact->summary();
    if (summary.method != ContactMethod::collocation) continue;
    ++by_collocation;
    const double pulled = std::abs(c.coefficients.gravity_along_mps2) * c.coefficients.dwell_s;
    const double moving = std::abs(c.touchdown.vx_mps) + ball.radius_m() * std::abs(c.touchdown.omega_radps) -
                          c.touchdown.vy_mps + pulled;
    const double scale = ball.mass_kg * (pulled - c.touchdown.vy_mps) * moving * (1.0 + c.coefficients.mu);
    const double rounding = 8e-16 * summary.energy.kinetic_td_j;
    double before = contact->at(0.0).mechanical_energy_j;
    for (int k = 1; k <= 60; ++k) {
      const double now = contact->at(summary.dwell_s * k / 60.0).mechanical_energy_j;
      CHECK_TEXT(now <= before + 1e-9 * scale + rounding, text_of(c).c_str());
      before = now;
    }
    const impact::ContactEnergy& e = summary.energy;
    CHECK_TEXT(std::abs(e.kinetic_lost_j - e.dissipated_j()) <= 1e-8 * scale + rounding, text_of(c).c_str());
    for (const double loss : {e.normal_damping_j, e.sliding_j, e.tangential_damping_j, e.offset_j})
      CHECK_TEXT(loss >= -1e-9 * scale, text_of(c).c_str());
    DOUBLES_EQUAL_TEXT(ball.mass_kg * c.coefficients.gravity_along_mps2 * summary.dwell_distance_m,
                       e.gravity_work_j, 1e-12 * std::abs(e.gravity_work_j) + 1e-300, text_of(c).c_str());
  }
  CHECK(by_collocation > repetitions(150) * 3 / 4);
}

// Times to the tolerance of the dwell time, forces where friction has its peaks to the root of it.
TEST(Collocation, TheSummaryIsThatOfTheIntegrator) {
  ContactDraws draws(11);
  for (int i = 0; i < repetitions(100); ++i) {
    const ContactCase c = ordinary(draws);
    const auto got = impact::simulate(contact_ball(), c.touchdown, c.coefficients, collocation(1e-9));
    const auto exact = impact::simulate(contact_ball(), c.touchdown, c.coefficients, integrator(1e-12));
    if (got->method != ContactMethod::collocation) continue;
    const std::string text = text_of(c);
    LONGS_EQUAL_TEXT(exact->event_count, got->event_count, text.c_str());
    for (int k = 0; k < exact->event_count; ++k) {
      const auto& [time_s, kind] = exact->events[static_cast<std::size_t>(k)];
      DOUBLES_EQUAL_TEXT(time_s, got->events[static_cast<std::size_t>(k)].time_s,
                         1e-8 * c.coefficients.dwell_s, text.c_str());
    }
    CHECK_EQUAL(exact->skid_to_grip_s.has_value(), got->skid_to_grip_s.has_value());
    CHECK_EQUAL(exact->slip_zero_s.has_value(), got->slip_zero_s.has_value());
    LONGS_EQUAL(exact->friction_reversals, got->friction_reversals);
    const double length_m = (tangential_scale(c) - c.touchdown.vy_mps) * c.coefficients.dwell_s;
    DOUBLES_EQUAL_TEXT(exact->dwell_distance_m, got->dwell_distance_m,
                       1e-9 * length_m + 1e-12 * std::abs(exact->dwell_distance_m), text.c_str());
    DOUBLES_EQUAL_TEXT(exact->rotation_rad, got->rotation_rad,
                       1e-9 * length_m / contact_ball().radius_m() + 1e-12 * std::abs(exact->rotation_rad),
                       text.c_str());
    DOUBLES_EQUAL(exact->max_depth_m, got->max_depth_m, 1e-9 * exact->max_depth_m);
    DOUBLES_EQUAL(exact->max_force_n, got->max_force_n, 1e-9 * exact->max_force_n);
    DOUBLES_EQUAL(exact->max_friction_n, got->max_friction_n, 1e-5 * exact->max_friction_n);
    DOUBLES_EQUAL(exact->mean_offset_m, got->mean_offset_m, 1e-8 * contact_ball().radius_m());
  }
}

// The trajectory's states are solved to the tolerance along the segments, against those of steps of 1e-12.
TEST(Collocation, TheCourseAtGivenInstantsKeepsTheTolerance) {
  for (const Motion& shot : {Motion{15.0, -8.0, 20.0}, Motion{4.0, -8.0, 30.0}, Motion{-6.0, -9.0, 300.0}}) {
    const auto exact = impact::ContactTrajectory::make(contact_ball(), shot, {}, integrator(1e-12));
    for (const double tolerance : {1e-3, 1e-6, 1e-9}) {
      const auto got = impact::ContactTrajectory::make(contact_ball(), shot, {}, collocation(tolerance));
      CHECK_TRUE(got->summary().method == ContactMethod::collocation);
      const double speed = 10.0 * tolerance, length = speed * 5e-3;
      for (int i = 0; i <= 200; ++i) {
        const impact::ContactState a = exact->at(25e-6 * i), b = got->at(25e-6 * i);
        DOUBLES_EQUAL(a.vx_mps, b.vx_mps, speed);
        DOUBLES_EQUAL(a.vy_mps, b.vy_mps, 1e-11);
        DOUBLES_EQUAL(a.omega_radps, b.omega_radps, speed / 0.03);
        DOUBLES_EQUAL(a.x_m, b.x_m, length);
        DOUBLES_EQUAL(a.y_m, b.y_m, 1e-13);
        DOUBLES_EQUAL(a.rotation_rad, b.rotation_rad, length / 0.03);
        DOUBLES_EQUAL(a.dissipated_j, b.dissipated_j, 10.0 * tolerance);
      }
    }
  }
}

// Without an event and away from the ends of the contact: halving the segments divides the error of the end by 2^2n.
TEST(Collocation, ASegmentsEndIsOfTwiceTheNodesOrder) {
  using namespace impact::detail;
  const auto system =
      impact::detail::make_system(contact_ball(), {30.0, -8.0, 200.0}, {.mu = 0.1, .offset_share = 0.3});
  const auto constants = CollocationConstants::make(*system);
  const double first = 0.2 * constants->normal.end(), last = 0.8 * constants->normal.end();
  const auto couple = [&](int parts) {
    SegmentSolver<4> solver(*constants, 1e-15);
    Segment segment;
    segment.mode = impact::ContactMode::slips_forward;
    segment.from = constants->normal.at(constants->normal.tau(first));
    segment.start.slip = system->slip0;
    for (int i = 1; i <= parts; ++i) {
      segment.x = first + (last - first) * (i - 1) / parts;
      segment.size = (last - first) / parts;
      NormalState to{.tau = constants->normal.tau(segment.x + segment.size)};
      solver.solve(segment, to, true);
      segment.from = to;
      segment.start = solver.end();
    }
    return segment.start.couple;
  };
  const double exact = couple(32);
  DOUBLES_EQUAL(8.0, std::log2(std::abs(couple(2) - exact) / std::abs(couple(8) - exact)) / 2.0, 0.7);
}

TEST(Collocation, WhereItGivesUpTheIntegratorsResultIsGivenAndTold) {
  // A grip that decays within a thousandth of the contact.
  const ContactCoefficients stiff{.stiffness_ratio = 1e3, .damping_ratio = 10.0};
  const auto told = impact::simulate(contact_ball(), {5.0, -8.0, -100.0}, stiff, collocation(1e-6));
  const auto asked = impact::simulate(contact_ball(), {5.0, -8.0, -100.0}, stiff, integrator(1e-12));
  CHECK_EQUAL(asked.has_value(), told.has_value());
  CHECK_TRUE(told->method == ContactMethod::dormand_prince);
  DOUBLES_EQUAL(asked->lift_off.vx_mps, told->lift_off.vx_mps, 0.0);
  DOUBLES_EQUAL(asked->lift_off.omega_radps, told->lift_off.omega_radps, 0.0);
}
