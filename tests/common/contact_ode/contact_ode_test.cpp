// The integrated contact against closed forms of its special cases, its methods' orders, its errors.
#include "common/impact/ode/contact_ode.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/impact/ode/contact_system.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/contact_ode/reference.hpp"
#include "tests/support/allocations.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;

namespace {

const ball::Ball kBall{.alpha = 0.55};
const Motion kShot{15.0, -8.0, 20.0};

/// Without an offset: the parts that closed forms describe.
ContactCoefficients plain(double mu, double damping_ratio = 0.75) {
  return {.e = 0.8, .dwell_s = 5e-3, .mu = mu, .damping_ratio = damping_ratio, .offset_share = 0.0};
}

constexpr std::array kMethods{ContactMethod::collocation, ContactMethod::dormand_prince};

ContactSummary contact_of(ContactMethod method, const Motion& touchdown, const ContactCoefficients& c,
                          double tolerance = 1e-11) {
  const auto summary = simulate(kBall, touchdown, c, {.method = method, .tolerance = tolerance});
  CHECK_TRUE(summary.has_value());
  CHECK_TRUE(summary->method == method);
  return *summary;
}

InputError error_of(const Motion& m, const ContactCoefficients& c, const ContactOptions& o = {},
                    const ball::Ball& b = kBall) {
  const auto result = simulate(b, m, c, o);
  CHECK_FALSE(result.has_value());
  return result.error();
}

}  // namespace

TEST_GROUP(ContactOde){};

TEST(ContactOde, TheNormalMotionIsThatOfTheClosedForm) {
  for (const ContactMethod method : kMethods) {
    for (const double e : {1.0, 0.95, 0.8, 0.5, 0.2, 0.14, 0.1, 0.01}) {
      ContactCoefficients c = plain(0.5);
      c.e = e;
      const ContactSummary s = contact_of(method, kShot, c);
      DOUBLES_EQUAL(8.0 * e, s.lift_off.vy_mps, 8e-10);
      DOUBLES_EQUAL(5e-3, s.dwell_s, e < 0.14 ? 5e-11 : 5e-13);  // the force fades slowly there
      // The deepest point of exp(-zeta t) sin(q t)/q is where tan(q t) = q/zeta.
      const auto spring = normal_spring(kBall.mass_kg, e, c.dwell_s);
      const double zeta = spring->damping_ratio;
      if (zeta >= 1.0) continue;
      const double q = std::sqrt(1.0 - zeta * zeta), turn = std::atan2(q, zeta);
      DOUBLES_EQUAL(turn / q / spring->frequency_radps, s.max_depth_time_s, 1e-12);
      DOUBLES_EQUAL(8.0 / spring->frequency_radps * std::exp(-zeta / q * turn), s.max_depth_m, 1e-11);
    }
  }
}

TEST(ContactOde, SlidingThroughoutIsTheRigidSlide) {
  for (const ContactMethod method : kMethods) {
    const Motion shot{20.0, -3.0, 100.0};
    const ContactSummary s = contact_of(method, shot, plain(0.4));
    const auto slide = rigid(kBall, shot, 0.8, 0.4);
    CHECK_EQUAL(Regime::slides, slide->regime);
    CHECK_EQUAL(Regime::slides, s.regime);
    DOUBLES_EQUAL(slide->lift_off.vx_mps, s.lift_off.vx_mps, 1e-9);
    DOUBLES_EQUAL(slide->lift_off.omega_radps, s.lift_off.omega_radps, 1e-7);
    DOUBLES_EQUAL(0.4, s.impulse_ratio, 1e-10);
    CHECK_FALSE(s.skid_to_grip_s.has_value());
    CHECK_FALSE(s.slip_zero_s.has_value());
  }
}

// Friction that grows with the normal force in step: k_t = k·alpha/(1 + alpha) makes the tangential
// oscillation as long as the normal one, so that F/N = k_t·s/|vy| stays put and the ball grips all along; at
// release the slip has turned round: a superball.
TEST(ContactOde, AnElasticGripAsLongAsTheContactTurnsTheSlipRound) {
  for (const ContactMethod method : kMethods) {
    ContactCoefficients c = plain(5.0, 0.0);
    c.e = 1.0;
    c.stiffness_ratio = kBall.alpha / (1.0 + kBall.alpha);
    const ContactSummary s = contact_of(method, {4.0, -8.0, 30.0}, c);
    DOUBLES_EQUAL(-(4.0 + kBall.radius_m() * 30.0), s.slip_lo_mps, 1e-8);
    CHECK_EQUAL(Regime::grips, s.regime);
    DOUBLES_EQUAL(0.0, *s.skid_to_grip_s, 0.0);
    DOUBLES_EQUAL(0.0, s.energy.dissipated_j() / s.energy.kinetic_td_j, 1e-9);
  }
}

TEST(ContactOde, WithoutFrictionOnlyTheNormalMotionChanges) {
  for (const ContactMethod method : kMethods) {
    const ContactSummary s = contact_of(method, kShot, plain(0.0));
    DOUBLES_EQUAL(15.0, s.lift_off.vx_mps, 0.0);
    DOUBLES_EQUAL(20.0, s.lift_off.omega_radps, 1e-13);
    DOUBLES_EQUAL(0.0, s.energy.sliding_j, 0.0);
  }
}

TEST(ContactOde, ADropWithoutSpinStaysUpright) {
  for (const ContactMethod method : kMethods) {
    for (const double offset : {0.0, 0.3}) {
      ContactCoefficients c = plain(0.5);
      c.offset_share = offset;
      const ContactSummary s = contact_of(method, {0.0, -8.0, 0.0}, c);
      DOUBLES_EQUAL(0.0, s.lift_off.vx_mps, 0.0);
      DOUBLES_EQUAL(0.0, s.lift_off.omega_radps, 0.0);
      CHECK_EQUAL(Regime::grips, s.regime);
    }
  }
}

TEST(ContactOde, EventsStandWhereTheirLawsChange) {
  for (const ContactMethod method : kMethods) {
    const auto contact = ContactTrajectory::make(kBall, kShot, {}, {.method = method, .tolerance = 1e-10});
    int seen = 0;
    for (const ContactEvent& event : contact->summary().event_list()) {
      const ContactState z = contact->at(event.time_s);
      const double limit = 0.537 * z.fy_n;
      if (event.kind == ContactEventKind::grip || event.kind == ContactEventKind::slip)
        DOUBLES_EQUAL(limit, std::abs(z.fx_n), 1e-8);
      if (event.kind == ContactEventKind::deepest) DOUBLES_EQUAL(0.0, z.vy_mps, 1e-8);
      if (event.kind == ContactEventKind::friction_reversal) DOUBLES_EQUAL(0.0, z.fx_n, 1e-7);
      if (event.kind == ContactEventKind::release) DOUBLES_EQUAL(0.0, z.fy_n, 1e-9);
      if (event.kind == ContactEventKind::largest_force)
        CHECK(z.fy_n > contact->at(event.time_s * 1.001).fy_n &&
              z.fy_n > contact->at(event.time_s * 0.999).fy_n);
      ++seen;
    }
    LONGS_EQUAL(6, seen);
  }
}

// A search over 20,000 states misses a flat top by less than (pi/20000)²/8 of it, and a corner, where the mode
// changes, by the slope over half an interval: friction rises and falls by less than 20 times its largest
// value in a dwell time, 5e-4.
TEST(ContactOde, LargestForcesAreThoseOfTheTrajectory) {
  for (const ContactMethod method : kMethods) {
    for (const Motion& shot :
         {kShot, Motion{4.0, -8.0, 30.0}, Motion{25.0, -4.0, 0.0}, Motion{-6.0, -9.0, 300.0}}) {
      const auto contact = ContactTrajectory::make(kBall, shot, {}, {.method = method});
      double friction_n = 0.0, normal_n = 0.0;
      for (int i = 0; i <= 20000; ++i) {
        const ContactState z = contact->at(contact->summary().dwell_s * i / 20000.0);
        friction_n = std::max(friction_n, std::abs(z.fx_n));
        normal_n = std::max(normal_n, z.fy_n);
      }
      DOUBLES_EQUAL(1.0, contact->summary().max_friction_n / friction_n, 5e-4);
      DOUBLES_EQUAL(1.0, contact->summary().max_force_n / normal_n, 1e-7);
    }
  }
}

TEST(ContactOde, ABallThatRollsAtTouchdownDoesNotSlipAtAll) {
  for (const ContactMethod method : kMethods) {
    // R = 1/32 m: vx + R·omega is 0 without rounding.
    const auto s =
        simulate({.diameter_m = 0.0625, .alpha = 0.55}, {8.0, -8.0, -256.0}, plain(0.5), {.method = method});
    DOUBLES_EQUAL(0.0, s->slip_zero_s.value(), 0.0);
    DOUBLES_EQUAL(0.0, s->skid_to_grip_s.value(), 0.0);
    DOUBLES_EQUAL(8.0, s->lift_off.vx_mps, 1e-12);
    LONGS_EQUAL(0, s->friction_reversals);
  }
}

// What is asked for between steps is as good as the steps: the states of a coarse run against a fine one.
TEST(ContactOde, TheCourseBetweenStepsKeepsTheTolerance) {
  for (const ContactMethod method : kMethods) {
    const auto coarse = ContactTrajectory::make(kBall, kShot, {}, {.method = method, .tolerance = 1e-9});
    const auto fine = ContactTrajectory::make(kBall, kShot, {},
                                              {.method = ContactMethod::dormand_prince, .tolerance = 1e-12});
    for (int i = 0; i <= 1000; ++i) {
      const double t = 5e-6 * i;
      const ContactState a = coarse->at(t);
      const ContactState b = fine->at(t);
      DOUBLES_EQUAL(b.vx_mps, a.vx_mps, 1e-8);
      DOUBLES_EQUAL(b.omega_radps, a.omega_radps, 3e-7);
      DOUBLES_EQUAL(b.x_m, a.x_m, 1e-10);
      DOUBLES_EQUAL(b.rotation_rad, a.rotation_rad, 1e-9);
      DOUBLES_EQUAL(b.fy_n, a.fy_n, 1e-6);
    }
  }
}

// Central differences over 2e-7 s: third derivatives are some v·omega², 8·630² m/s³, which leaves 1e-8 of a velocity, and
// 1e-5 of the force per mass; rounding leaves as much.
TEST(ContactOde, TheCourseIsOneMotionFromTouchdownToLiftOff) {
  for (const ContactMethod method : kMethods) {
    const auto contact = ContactTrajectory::make(kBall, kShot, {}, {.method = method, .tolerance = 1e-10});
    const ContactSummary& summary = contact->summary();
    constexpr double kStep_s = 1e-7;
    for (double share = 0.05; share < 1.0; share += 0.1) {
      const double t = share * summary.dwell_s;
      const ContactState z = contact->at(t), before = contact->at(t - kStep_s),
                         after = contact->at(t + kStep_s);
      const auto rate = [&](double ContactState::*number) {
        return (after.*number - before.*number) / (2.0 * kStep_s);
      };
      DOUBLES_EQUAL(rate(&ContactState::x_m), z.vx_mps, 1e-6);
      DOUBLES_EQUAL(rate(&ContactState::y_m), z.vy_mps, 1e-6);
      DOUBLES_EQUAL(rate(&ContactState::rotation_rad), z.omega_radps, 1e-4);
      DOUBLES_EQUAL(kBall.mass_kg * rate(&ContactState::vx_mps), z.fx_n, 1e-3);
      DOUBLES_EQUAL(kBall.mass_kg * rate(&ContactState::vy_mps), z.fy_n, 1e-3);
      DOUBLES_EQUAL(z.vx_mps + kBall.radius_m() * z.omega_radps, z.slip_mps, 1e-12);
    }
    const ContactState end = contact->at(summary.dwell_s);
    DOUBLES_EQUAL(summary.lift_off.vx_mps, end.vx_mps, 1e-8);
    DOUBLES_EQUAL(summary.lift_off.vy_mps, end.vy_mps, 1e-8);
    DOUBLES_EQUAL(summary.lift_off.omega_radps, end.omega_radps, 1e-6);
    DOUBLES_EQUAL(summary.dwell_distance_m, end.x_m, 1e-11);
    DOUBLES_EQUAL(summary.rotation_rad, end.rotation_rad, 1e-9);
  }
}

// The sum of the losses is what the motion has lost, although neither is computed from the other.
TEST(ContactOde, LossesSumToTheKineticEnergyLost) {
  for (const ContactMethod method : kMethods) {
    for (const double gravity : {0.0, 9.81}) {
      ContactCoefficients c;
      c.gravity_mps2 = gravity;
      const ContactEnergy e = contact_of(method, kShot, c).energy;
      DOUBLES_EQUAL(e.kinetic_lost_j, e.dissipated_j(), 1e-10 * e.kinetic_td_j);
      DOUBLES_EQUAL(e.kinetic_td_j - e.kinetic_lo_j, e.kinetic_lost_j, 1e-13 * e.kinetic_td_j);
      CHECK(e.normal_damping_j > 0.0 && e.sliding_j > 0.0 && e.tangential_damping_j > 0.0 &&
            e.offset_j > 0.0);
    }
  }
}

TEST(ContactOde, GravityAddsItsImpulseToThatOfTheRebound) {
  for (const ContactMethod method : kMethods) {
    ContactCoefficients c = plain(0.3);
    c.gravity_mps2 = 9.81;
    const Motion shot{30.0, -5.0, 0.0};
    const ContactSummary s = contact_of(method, shot, c);
    // Sliding throughout: friction has mu of the normal impulse, the weight's part included.
    DOUBLES_EQUAL(0.3 * (5.0 + s.lift_off.vy_mps + 9.81 * s.dwell_s), 30.0 - s.lift_off.vx_mps, 1e-9);
  }
}

// Along the surface it acts whether the ball slides or not; friction's share does not know of it.
TEST(ContactOde, AWeightAlongThePlateAddsItsImpulseToASlide) {
  ContactCoefficients c = plain(0.3);
  c.gravity_along_mps2 = -9.81 * 0.5;
  const Motion shot{30.0, -5.0, 0.0};
  for (const ContactMethod method : kMethods) {
    const auto s = simulate(kBall, shot, c, {.method = method, .tolerance = 1e-11});
    const double impulse = 5.0 + s->lift_off.vy_mps, fall = c.gravity_along_mps2 * s->dwell_s;
    CHECK_TRUE(s->method == method);
    CHECK_EQUAL(Regime::slides, s->regime);
    DOUBLES_EQUAL(30.0 - 0.3 * impulse + fall, s->lift_off.vx_mps, 1e-9);
    DOUBLES_EQUAL(-0.3 * impulse, kBall.alpha * kBall.radius_m() * s->lift_off.omega_radps, 1e-9);
    DOUBLES_EQUAL(kBall.mass_kg * c.gravity_along_mps2 * s->dwell_distance_m, s->energy.gravity_work_j,
                  1e-12);
    DOUBLES_EQUAL(s->energy.kinetic_lost_j, s->energy.dissipated_j(), 1e-9);
  }
}

// A whole oscillation, about the stretch that holds the weight, within the contact: the slip is that of touchdown again, so
// that friction has taken from vx what the weight gave to it and not to the spin.
TEST(ContactOde, AnElasticGripHoldsTheWeightAlongThePlate) {
  ContactCoefficients c = plain(5.0, 0.0);
  c.e = 1.0;
  c.stiffness_ratio = 4.0 * kBall.alpha / (1.0 + kBall.alpha);
  c.gravity_along_mps2 = 20.0;
  const double slip = 4.0 + kBall.radius_m() * 30.0, fall = c.gravity_along_mps2 * c.dwell_s;
  for (const ContactMethod method : kMethods) {
    const auto s = simulate(kBall, {4.0, -8.0, 30.0}, c, {.method = method, .tolerance = 1e-11});
    CHECK_TRUE(s->method == method);
    const double friction = -fall / (1.0 + 1.0 / kBall.alpha);
    DOUBLES_EQUAL(slip, s->slip_lo_mps, 1e-9);
    DOUBLES_EQUAL(4.0 + friction + fall, s->lift_off.vx_mps, 1e-9);
    DOUBLES_EQUAL(30.0 + friction / (kBall.alpha * kBall.radius_m()), s->lift_off.omega_radps, 1e-7);
  }
}

// A drop on an inclined plate: with friction it begins to roll down, without it slides down.
TEST(ContactOde, ADropOnAnInclinedPlateGoesDownIt) {
  for (const double mu : {0.0, 0.5}) {
    for (const double damping : {0.0, 0.75}) {
      ContactCoefficients c = plain(mu, damping);
      c.gravity_along_mps2 = 5.0;
      for (const ContactMethod method : kMethods) {
        const auto s = simulate(kBall, {0.0, -8.0, 0.0}, c, {.method = method});
        CHECK_TRUE(s.has_value());
        const double fall = c.gravity_along_mps2 * s->dwell_s;
        if (mu == 0.0) {
          DOUBLES_EQUAL(fall, s->lift_off.vx_mps, 1e-9);
          DOUBLES_EQUAL(0.0, s->lift_off.omega_radps, 0.0);
        } else {
          CHECK(s->lift_off.vx_mps > 0.0 && s->lift_off.vx_mps < fall);
          CHECK(s->lift_off.omega_radps < 0.0);
        }
        // alpha·R·omega is friction's impulse, and so is vx less what the weight gives.
        DOUBLES_EQUAL(s->lift_off.vx_mps - fall, kBall.alpha * kBall.radius_m() * s->lift_off.omega_radps,
                      1e-9);
      }
    }
  }
}

TEST(ContactOde, AWeightThatHoldsTheBallIsNamed) {
  for (const ContactMethod method : kMethods) {
    ContactCoefficients c = plain(0.3);
    c.gravity_mps2 = 9.81;
    CHECK_EQUAL(InputError::no_release, error_of({1e-3, -1e-6, 0.0}, c, {.method = method}));
  }
}

TEST(ContactOde, StepsOfTheAdaptiveMethodAreOfFifthOrderWithAFourthOrderError) {
  const auto s = impact::detail::make_system(kBall, {15.0, -8.0, 20.0}, plain(0.55));
  const auto carry = [&](int n, double& last_error) {
    impact::detail::State z{};
    z[impact::detail::kDepthRate] = 1.0;
    impact::detail::State error{};
    for (int i = 0; i < n; ++i) {
      const impact::detail::State k1 = impact::detail::derivative(*s, z, ContactMode::grips);
      z = impact::detail::take_step_with_error(*s, ContactMode::grips, z, k1, 2.0 / n, error);
    }
    last_error = std::abs(error[impact::detail::kStretch]);
    return z[impact::detail::kStretch];
  };
  double e32 = 0.0, e64 = 0.0, unused = 0.0;
  const double exact = carry(4000, unused);
  const double ratio = std::abs(carry(32, e32) - exact) / std::abs(carry(64, e64) - exact);
  DOUBLES_EQUAL(5.0, std::log2(ratio), 0.15);
  DOUBLES_EQUAL(5.0, std::log2(e32 / e64), 0.2);  // of one step: order 4, and 1 for the step
}

TEST(ContactOde, EveryToleranceIsKept) {
  for (const ContactMethod method : kMethods) {
    const ContactCoefficients c;
    const ContactSummary exact = contact_of(ContactMethod::dormand_prince, kShot, c, 1e-12);
    for (double tolerance = 1e-3; tolerance > 2e-12; tolerance *= 0.1) {
      const ContactSummary s = contact_of(method, kShot, c, tolerance);
      DOUBLES_EQUAL(exact.lift_off.vx_mps, s.lift_off.vx_mps, 8.0 * tolerance + 1e-12);
      DOUBLES_EQUAL(exact.lift_off.vy_mps, s.lift_off.vy_mps, 8.0 * tolerance + 1e-12);
      DOUBLES_EQUAL(kBall.radius_m() * exact.lift_off.omega_radps, kBall.radius_m() * s.lift_off.omega_radps,
                    8.0 * tolerance + 1e-12);
    }
  }
}

TEST(ContactOde, NothingIsAllocatedOnTheWay) {
  std::int64_t allocated = -1;
  bool done = true;
  {
    const strobe::testing::AllocationCounter counter;
    for (const ContactMethod method : kMethods)
      done = simulate(kBall, kShot, {}, {.method = method}).has_value() && done;
    allocated = counter.count();
  }
  CHECK_TRUE(done);
  LONGS_EQUAL(0, allocated);
}

// The tangential spring swings at the root of k_t/k·(1 + 1/alpha), 67.1 times as fast as the normal one, whose contact of
// e = .67 takes 2.89 of its radians: 61.8 half swings. In 34 digits; the reference's steps are a fiftieth of a swing.
TEST(ContactOde, AVeryStiffSpringsReversalsAreAllCountedThoughNotAllListed) {
  const ball::Ball ball{.alpha = 0.285};
  const ContactCoefficients c{.e = 0.67, .mu = 0.64, .stiffness_ratio = 1000.0, .damping_ratio = 0.01, .offset_share = 0.0};
  for (const double omega : {2.0, 150.0}) {
    const Motion touchdown{0.0, -27.2, omega};
    const auto exact = testing::reference_contact(ball, touchdown, c, 1500);
    for (const auto method : kMethods) {
      const auto s = simulate(ball, touchdown, c, {.method = method, .tolerance = 1e-9});
      CHECK_TRUE(s.has_value());
      DOUBLES_EQUAL(static_cast<double>(exact.vx_mps), s->lift_off.vx_mps, 1e-9 * 27.2);
      DOUBLES_EQUAL(static_cast<double>(exact.omega_radps), s->lift_off.omega_radps, 1e-9 * 27.2 / ball.radius_m());
      CHECK_EQUAL(ContactEventKind::release, s->event_list().back().kind);
      if (omega != 2.0) continue;  // it grips nearly throughout
      LONGS_EQUAL(61, s->friction_reversals);
      CHECK(s->events_left_out > 0);
      CHECK(s->event_count + s->events_left_out >= 61 + 3);  // and deepest, largest force, release
    }
  }
}

// The rate at which N falls to 0 is e: in the integrator an error of N is many times as long.
TEST(ContactOde, ALowRestitutionKeepsItsDwellTimeAtACoarseTolerance) {
  for (double e = 1e-3; e < 0.2; e *= 1.05) {
    const auto s = simulate(kBall, kShot, {.e = e}, {.method = ContactMethod::dormand_prince, .tolerance = 1e-3});
    CHECK_TRUE(s.has_value());
    DOUBLES_EQUAL(5e-3, s->dwell_s, 1e-3 * 5e-3);
    DOUBLES_EQUAL(8.0 * e, s->lift_off.vy_mps, 1e-3 * 8.0 * e);
  }
}

// The slip passes through 0, where there is nothing to grip with.
TEST(ContactOde, WithoutFrictionAWeightTurnsTheSlipRoundByItself) {
  for (const double damping : {0.0, 0.75})
    for (const auto method : kMethods) {
      ContactCoefficients c = plain(0.0, damping);
      c.gravity_along_mps2 = -900.0;
      const auto s = simulate(kBall, {1.0, -8.0, 20.0}, c, {.method = method, .tolerance = 1e-11});
      CHECK_TRUE(s.has_value());
      DOUBLES_EQUAL(1.0 - 900.0 * 5e-3, s->lift_off.vx_mps, 1e-10);
      DOUBLES_EQUAL(20.0, s->lift_off.omega_radps, 1e-10);
    }
}

TEST(ContactOde, InputsOutOfRangeAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const double tiny = std::numeric_limits<double>::denorm_min();
  const auto with = [](double ContactCoefficients::*member, double value) {
    ContactCoefficients c;
    c.*member = value;
    return c;
  };
  CHECK_EQUAL(InputError::not_finite, error_of({nan, -1.0, 0.0}, {}));
  CHECK_EQUAL(InputError::not_finite, error_of({1.0, -inf, 0.0}, {}));
  CHECK_EQUAL(InputError::not_approaching, error_of({1.0, 0.0, 0.0}, {}));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of({1.0, -tiny, 0.0}, {}));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of({1e300, -1.0, 0.0}, {}));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of({1.0, -1.0, 1e300}, {}));
  CHECK_EQUAL(InputError::ball_out_of_range, error_of(kShot, {}, {}, {.diameter_m = 0.0}));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of(kShot, {}, {}, {.mass_kg = tiny}));
  CHECK_EQUAL(InputError::restitution_out_of_range, error_of(kShot, with(&ContactCoefficients::e, 1.01)));
  CHECK_EQUAL(InputError::spring_out_of_range, error_of(kShot, with(&ContactCoefficients::e, 1e-4)));
  CHECK_EQUAL(InputError::friction_negative, error_of(kShot, with(&ContactCoefficients::mu, -0.1)));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of(kShot, with(&ContactCoefficients::mu, 1e300)));
  CHECK_EQUAL(InputError::dwell_not_positive, error_of(kShot, with(&ContactCoefficients::dwell_s, 0.0)));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of(kShot, with(&ContactCoefficients::dwell_s, tiny)));
  CHECK_EQUAL(InputError::spring_out_of_range,
              error_of(kShot, with(&ContactCoefficients::stiffness_ratio, 0.0)));
  CHECK_EQUAL(InputError::spring_out_of_range,
              error_of(kShot, with(&ContactCoefficients::damping_ratio, 1e-3)));
  CHECK_EQUAL(InputError::offset_out_of_range,
              error_of(kShot, with(&ContactCoefficients::offset_share, 1.5)));
  for (const double along : {1.1e3, -1.1e3})
    CHECK_EQUAL(InputError::magnitude_out_of_range,
                error_of(kShot, with(&ContactCoefficients::gravity_along_mps2, along)));
  CHECK_EQUAL(InputError::not_finite, error_of(kShot, with(&ContactCoefficients::gravity_along_mps2, nan)));
  CHECK_EQUAL(InputError::tolerance_out_of_range, error_of(kShot, {}, {.tolerance = 1e-14}));
  CHECK_EQUAL(InputError::tolerance_out_of_range, error_of(kShot, {}, {.tolerance = nan}));
}
