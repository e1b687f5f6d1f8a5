// The contact's integrator: order on smooth problems and with events and the offset's law, errors down to
// rounding, and what is left of angular momentum.
//
// Scales. System's units are |vy|, sqrt(m/k) and m, in which every number here is of order 1 to 10 and the
// motion neither grows nor shrinks much, so that the condition is of order 1. Each step rounds every
// component to half an ulp: n steps leave up to n·eps/2 if roundings agree in sign and about sqrt(n)·eps if
// they do not.
#include <algorithm>
#include <vector>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

#include "common/flight/aerodynamics.hpp"
#include "common/impact/ode/contact_system.hpp"
#include "common/impact/ode/contact_trajectory.hpp"
#include "sim/motion/ball_path.hpp"
#include "sim/motion/flight.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;

namespace {

struct Refinement {
  double steps = 0.0, error = 0.0;
};

/// Slope of log(error) over -log(steps) by least squares, over those refinements whose error is at least
/// `floor`: the order of the method on them. 0 with fewer than three.
double order_above(const std::vector<Refinement>& refinements, double floor) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const Refinement& r : refinements) {
    if (!(r.error >= floor)) continue;
    const double a = -std::log(r.steps), b = std::log(r.error);
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return n < 3.0 ? 0.0 : (n * xy - x * y) / (n * xx - x * x);
}

double least_error(const std::vector<Refinement>& refinements) {
  return std::ranges::min_element(refinements, {}, &Refinement::error)->error;
}

constexpr double kEps = std::numeric_limits<double>::epsilon();
const ball::Ball kBall{.alpha = 0.579};
const Motion kShot{15.0, -8.0, 20.0};
ContactCoefficients coefficients(double offset_share, double e = 0.8) {
  return {.e = e, .dwell_s = 5e-3, .mu = 0.55, .offset_share = offset_share};
}

/// Depth, depth rate and stretch after `time` of a ball that grips throughout; no offset. N = y + 2·zeta·y'.
impact::detail::State carried(const impact::detail::System& s, double time, int steps) {
  impact::detail::State z{};
  z[impact::detail::kDepthRate] = 1.0;
  const double h = time / steps;
  for (int i = 0; i < steps; ++i)
    z = impact::detail::take_step(s, ContactMode::grips, z,
                                  impact::detail::derivative(s, z, ContactMode::grips), h);
  return z;
}

std::vector<Refinement> depth_errors(int fewest, int most) {
  const auto system = impact::detail::make_system(kBall, kShot, coefficients(0.0));
  const double time = 2.0, q = std::sqrt(1.0 - system->zeta * system->zeta);
  const double exact = std::exp(-system->zeta * time) * std::sin(q * time) / q;
  std::vector<Refinement> out;
  for (int n = fewest; n <= most; n *= 2)
    out.push_back({static_cast<double>(n),
                   std::abs(carried(*system, time, n)[impact::detail::kDepth] - exact)});
  return out;
}

ContactOptions integrator(double tolerance) {
  return {.method = ContactMethod::dormand_prince, .tolerance = tolerance};
}

}  // namespace

TEST_GROUP(ContactConvergence){};

// A damped oscillation, known in closed form: of fifth order, whose next terms bend the slope by a few hundredths, down to
// the roundings of the steps, and from there no further: more steps round more often.
TEST(ContactConvergence, TheErrorFallsWithTheFifthPowerToRoundingAndStaysThere) {
  DOUBLES_EQUAL(5.0, order_above(depth_errors(32, 512), 1e-13), 0.1);
  const auto errors = depth_errors(8, 131072);
  CHECK(least_error(errors) <= 32.0 * kEps);
  for (const Refinement& r : errors)
    if (r.steps >= 4096.0) CHECK(r.error <= std::sqrt(r.steps) * kEps);
  // Rounding is not reached by luck: past it the error does not fall as the order would have it.
  CHECK(errors.back().error > kEps);
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

// Friction acts on vx at the mass m and on the spin at the inertia alpha·m·R² with the arm R, both at every
// instant by the same force: m·R·vx - alpha·m·R²·omega, what is left of the angular momentum about the point
// of contact where the weight and the ball's height play no part, changes by the couple of the normal force
// alone. Both sides are linear in the state, and a Runge-Kutta step takes linear combinations of slopes: the
// balance holds for every step of every size, to the rounding of the sums.
TEST(ContactConvergence, AngularMomentumChangesByTheOffsetsImpulseAlone) {
  for (const double offset : {0.0, 0.15, 0.6}) {
    for (const double tolerance : {1e-3, 1e-6, 1e-12}) {
      const ContactSummary s = *simulate(kBall, kShot, coefficients(offset), integrator(tolerance));
      const double r = kBall.radius_m();
      const double spin = kBall.alpha * r * (s.lift_off.omega_radps - kShot.omega_radps);
      const double slide = s.lift_off.vx_mps - kShot.vx_mps;
      const double couple = s.mean_offset_m / r * (s.lift_off.vy_mps - kShot.vy_mps);
      DOUBLES_EQUAL(couple, spin - slide, 2.0 * s.steps * kEps * 20.0);
    }
  }
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

// The two flights of this project against each other: the rig's Runge-Kutta steps, which are its truth, and
// the reduction's third-order series. They share no code. What a flight without drag keeps, it keeps here
// too.

namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();
const sim::FlightState kStart{.x_m = 0.3, .y_m = 0.2, .vx_mps = 15.0, .vy_mps = -6.0};
constexpr double kSpin_radps = 200.0;
const double kSpeed_mps = std::hypot(15.0, 6.0);

sim::Scene scene_of(double density_kgpm3, double drag_coefficient = 0.55) {
  sim::Scene scene;
  scene.air.density_kgpm3 = density_kgpm3;
  scene.air.drag_coefficient = drag_coefficient;
  scene.air.spin_decay_per_m = 0.0;  // the series' spin is constant
  return scene;
}

sim::FlightState flown(const sim::Scene& scene, const sim::FlightState& from, double spin, double time_s) {
  return sim::Flight(scene, from, spin).at(time_s);
}

/// In so many flights one after another.
sim::FlightState in_parts(const sim::Scene& scene, sim::FlightState s, double time_s, int parts) {
  for (int i = 0; i < parts; ++i) s = flown(scene, s, kSpin_radps, time_s / parts);
  return s;
}

flight::Flight series_of(const sim::Scene& scene) {
  const auto air = flight::aerodynamics(scene.ball, scene.air.density_kgpm3);
  const Eigen::Vector2d velocity{kStart.vx_mps, kStart.vy_mps};
  return {{kStart.x_m, kStart.y_m},
          velocity,
          flight::forcing(air, flight::gravity_mps2(0.0), velocity, kSpin_radps)};
}

double distance(const sim::FlightState& a, const sim::FlightState& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

TEST_GROUP(FlightConvergence){};

// One step of the classical method errs by the fifth power of its length. In air 400 times as dense as ours,
// since in ours the error is rounding (next test).
TEST(FlightConvergence, OneStepOfTheRigsFlightErrsByTheFifthPower) {
  const sim::Scene thick = scene_of(500.0);
  std::vector<Refinement> errors;
  for (const double per_step : {1.0, 2.0, 4.0, 8.0}) {
    const double h = 2e-3 / per_step;
    const sim::FlightState exact = in_parts(thick, kStart, h, 64);
    errors.push_back({per_step, distance(flown(thick, kStart, kSpin_radps, h), exact)});
  }
  DOUBLES_EQUAL(5.0, order_above(errors, 1e-15), 0.3);
}

// 80 steps of 2 ms, 1280 of an eighth: what differs is the roundings of the way flown, 2.6 m.
TEST(FlightConvergence, InOurAirTheRigsStepsErrByRounding) {
  const sim::Scene scene = scene_of(1.2);
  const sim::FlightState a = flown(scene, kStart, kSpin_radps, 0.16);
  const sim::FlightState b = in_parts(scene, kStart, 0.16, 1280);
  DOUBLES_EQUAL(0.0, distance(a, b), 1280.0 * kRounding * 2.6);
  DOUBLES_EQUAL(b.vx_mps, a.vx_mps, 1280.0 * kRounding * 16.0);
  DOUBLES_EQUAL(b.vy_mps, a.vy_mps, 1280.0 * kRounding * 16.0);
}

// The series holds acceleration and jerk: positions err by the fourth power of time, velocities by the third.
TEST(FlightConvergence, TheReductionsSeriesErrsByTheFourthPower) {
  const sim::Scene scene = scene_of(1.2);
  const flight::Flight series = series_of(scene);
  std::vector<Refinement> places, speeds;
  for (const double parts : {1.0, 2.0, 4.0, 8.0}) {
    const double t = 0.08 / parts;
    const sim::FlightState exact = flown(scene, kStart, kSpin_radps, t);
    const Eigen::Vector2d p = series.position_at(t), v = series.velocity_at(t);
    places.push_back({parts, std::hypot(p.x() - exact.x_m, p.y() - exact.y_m)});
    speeds.push_back({parts, std::hypot(v.x() - exact.vx_mps, v.y() - exact.vy_mps)});
  }
  DOUBLES_EQUAL(4.0, order_above(places, 1e-14), 0.2);
  DOUBLES_EQUAL(3.0, order_above(speeds, 1e-13), 0.2);
}

// Without drag and decay the laws are the same backwards: thrown back from the end, with the spin turned
// round, the ball returns to where it came from. (The lift's v·(z × v)·C_L(omega) keeps its sign.)
TEST(FlightConvergence, AFlightWithoutDragRunsBackToItsStart) {
  const sim::Scene scene = scene_of(1.2, 0.0);
  for (const double time_s : {0.003, 0.05, 0.4, -0.2}) {
    const sim::FlightState end = flown(scene, kStart, kSpin_radps, time_s);
    sim::FlightState back = end;
    back.vx_mps = -end.vx_mps;
    back.vy_mps = -end.vy_mps;
    const sim::FlightState start = flown(scene, back, -kSpin_radps, time_s);
    // 200 steps there and back.
    DOUBLES_EQUAL(0.0, distance(kStart, start), 400.0 * kRounding * (1.0 + kSpeed_mps * std::abs(time_s)));
    DOUBLES_EQUAL(-kStart.vx_mps, start.vx_mps, 400.0 * kRounding * kSpeed_mps);
    DOUBLES_EQUAL(-kStart.vy_mps, start.vy_mps, 400.0 * kRounding * kSpeed_mps);
  }
}

// With drag it does not: what it lost it does not get back.
TEST(FlightConvergence, AFlightWithDragDoesNot) {
  const sim::Scene scene = scene_of(1.2);
  sim::FlightState back = flown(scene, kStart, kSpin_radps, 0.4);
  back.vx_mps = -back.vx_mps;
  back.vy_mps = -back.vy_mps;
  CHECK(distance(kStart, flown(scene, back, -kSpin_radps, 0.4)) > 0.1);
}

// Energy along the rig's whole paths: flight, contact, flight.
using namespace strobe::sim;

namespace {

constexpr double kGravity_mps2 = 9.80665;

/// Any ball on any surface within a scene's ranges.
Scene any_scene(std::mt19937_64& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Scene scene;
  scene.machine.speed_mps = between(1.0, 60.0);
  scene.machine.angle_rad = -between(5.0, 85.0) * std::numbers::pi / 180.0;
  scene.machine.spin_radps = between(-600.0, 600.0);
  scene.bounce.e = between(0.2, 0.98);
  scene.bounce.e_slope_spm = 0.0;
  scene.bounce.mu = between(0.0, 1.2);
  scene.bounce.dwell_s = between(1e-3, 8e-3);
  scene.bounce.stiffness_ratio = between(0.3, 3.0);
  scene.bounce.damping_ratio = between(0.05, 2.0);
  scene.bounce.offset_share = between(0.0, 0.4);
  return scene;
}

/// Of motion and height, J. In contact the springs hold more, never less than nothing.
double energy_j(const Scene& scene, const BallState& s) {
  const ball::Ball& b = scene.ball;
  return 0.5 * b.mass_kg * (s.vx_mps * s.vx_mps + s.vy_mps * s.vy_mps) +
         0.5 * b.inertia_kgm2() * s.omega_radps * s.omega_radps + b.mass_kg * kGravity_mps2 * s.y_m;
}

}  // namespace

TEST_GROUP(PathEnergy){};

// The integration's tolerance is 1e-9 of the speeds.
TEST(PathEnergy, NeverGrowsFromTouchdownToLiftOffAndBeyond) {
  const unsigned seed = std::random_device{}();
  std::mt19937_64 random(seed);
  int bounced = 0;
  for (int i = 0; i < 300; ++i) {
    const Scene scene = any_scene(random);
    const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
    char text[80];
    std::snprintf(text, sizeof text, "seed %u, scene %d", seed, i);
    if (!path) continue;  // the weight holds a slow ball
    ++bounced;
    const double start = energy_j(scene, path->at(0.0));
    for (int k = 1; k <= 100; ++k)
      CHECK_TEXT(energy_j(scene, path->at(path->dwell_s() * k / 100.0)) <= start * (1.0 + 1e-8), text);
    double before = energy_j(scene, path->at(path->dwell_s()));
    for (int k = 1; k <= 20; ++k) {
      const double now = energy_j(scene, path->at(path->dwell_s() + 5e-3 * k));
      CHECK_TEXT(now <= before * (1.0 + 1e-12), text);
      before = now;
    }
    // Towards touchdown too the air only takes.
    CHECK_TEXT(energy_j(scene, path->at(-0.05)) >= start * (1.0 - 1e-12), text);
  }
  CHECK(bounced > 250);
}
