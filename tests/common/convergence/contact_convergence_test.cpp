// The contact's integrators: order on smooth problems and with events and the offset's law, errors down to
// rounding, sums of energy, and what is left of angular momentum.
//
// Scales. System's units are |vy|, sqrt(m/k) and m, in which every number here is of order 1 to 10 and the
// motion neither grows nor shrinks much, so that the condition is of order 1. Each step rounds every
// component to half an ulp: n steps leave up to n·eps/2 if roundings agree in sign and about sqrt(n)·eps if
// they do not.
#include <cmath>
#include <limits>

#include "common/impact/ode/contact_system.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/convergence/orders.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::least_error;
using strobe::testing::order_above;
using strobe::testing::Refinement;

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
const ball::Ball kBall{.alpha = 0.579};
const Motion kShot{15.0, -8.0, 20.0};
constexpr ContactMethod kMethods[] = {ContactMethod::dormand_prince, ContactMethod::rk4,
                                      ContactMethod::semi_implicit_euler};

ContactCoefficients coefficients(double offset_share, double e = 0.8) {
  return {.e = e, .dwell_s = 5e-3, .mu = 0.55, .offset_share = offset_share};
}

/// Depth, depth rate and stretch after `time` of a ball that grips throughout; no offset. N = y + 2·zeta·y'.
impact::detail::State carried(const impact::detail::System& s, ContactMethod method, double time, int steps) {
  impact::detail::State z{};
  z[impact::detail::kDepthRate] = 1.0;
  const double h = time / steps;
  for (int i = 0; i < steps; ++i)
    z = impact::detail::take_step(s, method, ContactMode::grips, z,
                                  impact::detail::derivative(s, z, ContactMode::grips), h);
  return z;
}

std::vector<Refinement> depth_errors(ContactMethod method, int fewest, int most) {
  const auto system = impact::detail::make_system(kBall, kShot, coefficients(0.0));
  const double time = 2.0, q = std::sqrt(1.0 - system->zeta * system->zeta);
  const double exact = std::exp(-system->zeta * time) * std::sin(q * time) / q;
  std::vector<Refinement> out;
  for (int n = fewest; n <= most; n *= 2)
    out.push_back({static_cast<double>(n),
                   std::abs(carried(*system, method, time, n)[impact::detail::kDepth] - exact)});
  return out;
}

ContactOptions integrator(double tolerance) {
  return {.method = ContactMethod::dormand_prince, .tolerance = tolerance};
}

/// Error of vx at lift-off in units of |vy| over fixed steps, against the adaptive method at its finest.
std::vector<Refinement> lift_off_errors(ContactMethod method, const ContactCoefficients& c, int fewest,
                                        int most) {
  const double exact = simulate(kBall, kShot, c, integrator(1e-12))->lift_off.vx_mps;
  std::vector<Refinement> out;
  for (int n = fewest; n <= most; n *= 2) {
    const double got = simulate(kBall, kShot, c, {.method = method, .steps = n})->lift_off.vx_mps;
    out.push_back({static_cast<double>(n), std::abs(got - exact) / -kShot.vy_mps});
  }
  return out;
}

}  // namespace

TEST_GROUP(ContactConvergence){};

// A damped oscillation, known in closed form. The method's terms of next order bend the slope by a few
// hundredths.
TEST(ContactConvergence, EveryMethodHasItsOrderOnASmoothProblem) {
  DOUBLES_EQUAL(5.0, order_above(depth_errors(ContactMethod::dormand_prince, 32, 512), 1e-13), 0.1);
  DOUBLES_EQUAL(4.0, order_above(depth_errors(ContactMethod::rk4, 16, 2048), 1e-13), 0.05);
  DOUBLES_EQUAL(1.0, order_above(depth_errors(ContactMethod::semi_implicit_euler, 64, 65536), 1e-13), 0.05);
}

// Down to the roundings of the steps that it took, and from there no further: more steps round more often.
TEST(ContactConvergence, TheErrorFallsToRoundingAndStaysThere) {
  for (const ContactMethod method : {ContactMethod::dormand_prince, ContactMethod::rk4}) {
    const auto errors = depth_errors(method, 8, 131072);
    CHECK(least_error(errors) <= 32.0 * kEps);
    for (const Refinement& r : errors)
      if (r.steps >= 4096.0) CHECK(r.error <= std::sqrt(r.steps) * kEps);
    // Rounding is not reached by luck: past it the error does not fall as the order would have it.
    CHECK(errors.back().error > kEps);
  }
}

// Grip, slip and release are located, so that a step never spans a change of law.
TEST(ContactConvergence, EventsCostNoOrder) {
  const ContactCoefficients c = coefficients(0.0);
  CHECK(simulate(kBall, kShot, c)->event_count > 3);
  DOUBLES_EQUAL(4.0, order_above(lift_off_errors(ContactMethod::rk4, c, 32, 1024), 2e-12), 0.3);
  DOUBLES_EQUAL(1.0, order_above(lift_off_errors(ContactMethod::semi_implicit_euler, c, 64, 16384), 2e-12),
                0.15);
}

// The offset's arm is the footprint's radius sqrt(y(2R - y)), which sets in as the root of time. Its couple
// d·N goes as t^(1/2)·2·zeta there, with an elastic spring as t^(1/2)·t: one step's quadrature errs by
// h^(3/2), h^(5/2), and so does the whole, whatever the method's own order. The elastic ball's footprint ends
// as it began; the damped one's does not, it leaves with its spring compressed.
TEST(ContactConvergence, TheOffsetsFootprintLimitsFixedStepsToThreeHalves) {
  DOUBLES_EQUAL(1.5, order_above(lift_off_errors(ContactMethod::rk4, coefficients(0.15), 64, 16384), 2e-12),
                0.1);
  DOUBLES_EQUAL(
      2.5, order_above(lift_off_errors(ContactMethod::rk4, coefficients(0.15, 1.0), 64, 4096), 2e-12), 0.15);
  DOUBLES_EQUAL(
      1.0,
      order_above(lift_off_errors(ContactMethod::semi_implicit_euler, coefficients(0.15), 64, 16384), 2e-12),
      0.15);
}

// The adaptive method makes its first step as small as the root asks for and keeps its order over the work:
// error over evaluations, both with the offset and without it, falls at least with the fourth power.
TEST(ContactConvergence, TheAdaptiveMethodKeepsItsOrderThroughEventsAndOffset) {
  for (const double offset : {0.0, 0.15}) {
    const ContactCoefficients c = coefficients(offset);
    const ContactSummary exact = *simulate(kBall, kShot, c, integrator(1e-12));
    std::vector<Refinement> errors;
    for (double tolerance = 1e-4; tolerance > 1e-10; tolerance *= 0.1) {
      const ContactSummary s = *simulate(kBall, kShot, c, integrator(tolerance));
      const double error =
          std::hypot(s.lift_off.vx_mps - exact.lift_off.vx_mps,
                     kBall.radius_m() * (s.lift_off.omega_radps - exact.lift_off.omega_radps));
      errors.push_back({static_cast<double>(s.evaluations), error / -kShot.vy_mps});
      CHECK(error / -kShot.vy_mps <= tolerance);
    }
    CHECK(order_above(errors, 2e-13) > 4.0);
  }
}

// Two methods that share no step agree to what rounding leaves of either.
TEST(ContactConvergence, MethodsMeetAtRounding) {
  const ContactCoefficients c = coefficients(0.0);
  const ContactSummary a = *simulate(kBall, kShot, c, integrator(1e-12));
  const ContactSummary b = *simulate(kBall, kShot, c, {.method = ContactMethod::rk4, .steps = 8192});
  DOUBLES_EQUAL(a.lift_off.vx_mps, b.lift_off.vx_mps, 1e-12 * 8.0);
  DOUBLES_EQUAL(a.dwell_s, b.dwell_s, 1e-12 * a.dwell_s);
  DOUBLES_EQUAL(a.rotation_rad, b.rotation_rad, 1e-12);
}

// The accounts are integrals of their own, one for each loss; what is missing between them and the motion's
// energy is the method's error, and in the end rounding: with 2^14 steps of RK4 at most 2^14·eps of the
// energy.
TEST(ContactConvergence, EnergyAccountsCloseAtTheMethodsOrderDownToRounding) {
  const ContactCoefficients c = coefficients(0.0);
  std::vector<Refinement> gaps;
  for (int n = 32; n <= 16384; n *= 2) {
    const ContactEnergy e = simulate(kBall, kShot, c, {.method = ContactMethod::rk4, .steps = n})->energy;
    gaps.push_back({static_cast<double>(n), std::abs(e.kinetic_lost_j - e.dissipated_j()) / e.kinetic_td_j});
  }
  DOUBLES_EQUAL(4.0, order_above(gaps, 1e-12), 0.5);
  CHECK(least_error(gaps) <= 16.0 * kEps);
  CHECK(gaps.back().error <= 16384 * kEps);
}

// Friction acts on vx at the mass m and on the spin at the inertia alpha·m·R² with the arm R, both at every
// instant by the same force: m·R·vx - alpha·m·R²·omega, what is left of the angular momentum about the point
// of contact where the weight and the ball's height play no part, changes by the couple of the normal force
// alone. Both sides are linear in the state, and a Runge-Kutta step takes linear combinations of slopes: the
// balance holds for every step of every size, to the rounding of the sums.
TEST(ContactConvergence, AngularMomentumChangesByTheOffsetsImpulseAlone) {
  for (const double offset : {0.0, 0.15, 0.6}) {
    for (const ContactMethod method : kMethods) {
      // Euler's speeds take the slope at a step's start, its accounts that at the new speeds: equal to first
      // order, and to rounding where there is no offset.
      if (method == ContactMethod::semi_implicit_euler && offset > 0.0) continue;
      for (const int steps : {4, 7, 50, 1000}) {
        for (const double tolerance : {1e-3, 1e-6, 1e-12}) {
          if (method != ContactMethod::dormand_prince && tolerance != 1e-3) continue;
          const ContactSummary s = *simulate(kBall, kShot, coefficients(offset),
                                             {.method = method, .tolerance = tolerance, .steps = steps});
          const double r = kBall.radius_m();
          const double spin = kBall.alpha * r * (s.lift_off.omega_radps - kShot.omega_radps);
          const double slide = s.lift_off.vx_mps - kShot.vx_mps;
          const double couple = s.mean_offset_m / r * (s.lift_off.vy_mps - kShot.vy_mps);
          DOUBLES_EQUAL(couple, spin - slide, 2.0 * s.steps * kEps * 20.0);
        }
      }
    }
  }
}

TEST(ContactConvergence, EulersAngularMomentumErrsToFirstOrderWithAnOffset) {
  std::vector<Refinement> gaps;
  for (int n = 64; n <= 8192; n *= 2) {
    const ContactSummary s = *simulate(kBall, kShot, coefficients(0.15),
                                       {.method = ContactMethod::semi_implicit_euler, .steps = n});
    const double r = kBall.radius_m();
    const double couple = s.mean_offset_m / r * (s.lift_off.vy_mps - kShot.vy_mps);
    const double balance =
        kBall.alpha * r * (s.lift_off.omega_radps - kShot.omega_radps) - (s.lift_off.vx_mps - kShot.vx_mps);
    gaps.push_back({static_cast<double>(n), std::abs(balance - couple)});
  }
  DOUBLES_EQUAL(1.0, order_above(gaps, 1e-13), 0.2);
}

// Not only at the end: at every instant of the course, between steps and at events.
TEST(ContactConvergence, AngularMomentumHoldsAllAlongTheCourse) {
  const auto contact = ContactTrajectory::make(kBall, kShot, coefficients(0.0), integrator(1e-6));
  for (int i = 0; i <= 500; ++i) {
    const ContactState z = contact->at(contact->summary().dwell_s * i / 500.0);
    DOUBLES_EQUAL(kBall.alpha * kBall.radius_m() * kShot.omega_radps - kShot.vx_mps,
                  kBall.alpha * kBall.radius_m() * z.omega_radps - z.vx_mps, 100.0 * kEps * 15.0);
  }
}
