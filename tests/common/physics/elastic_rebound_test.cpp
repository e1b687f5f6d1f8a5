// Elastic rebound against limits that have a formula, the contact mechanics' integrator, integration in small steps
// and a numerical solution of the whole footprint.
#include "common/impact/closed_form/elastic_rebound.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "common/impact/ode/contact_ode.hpp"
#include "tests/support/elastic_footprint.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;

namespace {

constexpr ball::Ball kSphere{.diameter_m = 0.005, .mass_kg = 2.5e-4, .alpha = 0.4};

Rebound rebound(const ball::Ball& ball, const Motion& touchdown, const ElasticCoefficients& c) {
  const auto out = elastic_rebound(ball, touchdown, c);
  CHECK_TEXT(out.has_value(), out ? "" : std::string(message(out.error())).c_str());
  return out.value_or(Rebound{});
}

double slip(const ball::Ball& ball, const Motion& m) { return m.vx_mps + ball.diameter_m / 2.0 * m.omega_radps; }

double tangential_energy(const ball::Ball& ball, const Motion& m) {
  return m.vx_mps * m.vx_mps + ball.alpha * std::pow(ball.diameter_m / 2.0 * m.omega_radps, 2);
}

struct Drawn {
  ball::Ball ball;
  Motion touchdown;
  ElasticCoefficients c;
};

Drawn drawn(std::mt19937_64& engine) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto between = [&](double a, double b) { return a + (b - a) * unit(engine); };
  Drawn d{.ball = kSphere, .touchdown = {}, .c = {}};
  d.ball.alpha = between(0.3, 2.0 / 3.0);
  d.touchdown = {between(-10.0, 10.0), -between(0.5, 10.0), between(-2000.0, 2000.0)};
  d.c = {.e = between(0.3, 1.0), .mu = between(0.02, 1.5), .stiffness_ratio = std::exp(between(-1.5, 2.0))};
  return d;
}

/// The stated law in small steps, friction by return mapping: an error of the steps' size.
double stepped_slip_lo(const Drawn& d, int steps) {
  const double beta = 1.0 + 1.0 / d.ball.alpha;
  double w = slip(d.ball, d.touchdown) / -d.touchdown.vy_mps, f = 0.0;
  for (const bool compresses : {true, false}) {
    const double rate = compresses ? 1.0 : d.c.e, dx = std::numbers::pi / 2.0 / steps;
    for (int i = 1; i <= steps; ++i) {
      const double n = compresses ? std::sin(i * dx) : std::max(0.0, std::cos(i * dx));
      const double before = f;
      const double trial = f + d.c.stiffness_ratio * rate * dx * (w - beta * f * rate * dx / 2.0);
      f = std::clamp(trial, -d.c.mu * n, d.c.mu * n);
      w -= beta * rate * dx * (before + f) / 2.0;
    }
  }
  return -d.touchdown.vy_mps * w;
}

}  // namespace

TEST_GROUP(ElasticRebound){};

// 2(1 - nu)/(2 - nu): 1 without transverse strain, 2/3 of what is incompressible; a rigid surface counts for nothing.
// chi = kappa·(1 + 1/alpha)/2 of a slice of a sphere (alpha 1/2) at nu .28 is 1.2558 in Maw, Barber and Fawcett.
TEST(ElasticRebound, StiffnessRatioIsMindlins) {
  DOUBLES_EQUAL(1.0, mindlin_stiffness_ratio(0.0), 0.0);
  DOUBLES_EQUAL(2.0 / 3.0, mindlin_stiffness_ratio(0.5), 1e-15);
  DOUBLES_EQUAL(1.2558, mindlin_stiffness_ratio(0.28) * 3.0 / 2.0, 0.5e-4);
  DOUBLES_EQUAL(mindlin_stiffness_ratio(0.5), mindlin_stiffness_ratio(0.5, 0.25, 1e12), 1e-9);
  DOUBLES_EQUAL(mindlin_stiffness_ratio(0.3), mindlin_stiffness_ratio(0.3, 0.3, 7.0), 1e-15);
}

TEST(ElasticRebound, WithoutFrictionNothingTangentialChanges) {
  const Motion touchdown{3.0, -4.0, -200.0};
  const Rebound out = rebound(kSphere, touchdown, {.e = 0.8, .mu = 0.0});
  DOUBLES_EQUAL(3.0, out.lift_off.vx_mps, 0.0);
  DOUBLES_EQUAL(-200.0, out.lift_off.omega_radps, 0.0);
  DOUBLES_EQUAL(3.2, out.lift_off.vy_mps, 1e-15);
}

// A contact that cannot slip is an oscillator: its slip is cos of eta times the contact's phase, eta² =
// kappa·(1 + 1/alpha), the phase pi/2 in compression and e·pi/2 in expansion. At the very end it slips all the same as
// the load goes, for mu = 1e9 during the last 1e-9 of the contact.
TEST(ElasticRebound, WithUnlimitedFrictionTheSlipOscillates) {
  for (const double e : {0.5, 0.98, 1.0}) {
    const double kappa = mindlin_stiffness_ratio(0.3), eta = std::sqrt(kappa * 3.5);
    const Motion touchdown{2.0, -1.0, 100.0};
    const Rebound out = rebound(kSphere, touchdown, {.e = e, .mu = 1e9, .stiffness_ratio = kappa});
    DOUBLES_EQUAL(2.25 * std::cos(eta * (1.0 + e) * std::numbers::pi / 2.0), out.slip_lo_mps, 1e-8);
    CHECK(out.regime == Regime::grips);
  }
}

// psi1 = kappa·s/(mu·|vy|) = 4·chi - 1 and 1 are the borders of Maw, Barber and Fawcett. Beyond the first the rebound is
// that of friction at its limit throughout, and the slip reverses where that is more than rolling takes.
TEST(ElasticRebound, SlidesThroughoutFromTheBorderOnThatTheFullSolutionHas) {
  const double mu = 0.092, kappa = mindlin_stiffness_ratio(0.3), chi = kappa * 3.5 / 2.0;
  const double border = (4.0 * chi - 1.0) * mu / kappa;
  const Motion beyond{border * (1.0 + 1e-12), -1.0, 0.0}, before{border * (1.0 - 1e-9), -1.0, 0.0};
  const Rebound slides = rebound(kSphere, beyond, {.mu = mu, .stiffness_ratio = kappa});
  CHECK(slides.regime == Regime::slides);
  DOUBLES_EQUAL(border - 2.0 * mu, slides.lift_off.vx_mps, 1e-12);
  CHECK(slides.slip_lo_mps < 0.0);
  CHECK(rebound(kSphere, before, {.mu = mu, .stiffness_ratio = kappa}).regime == Regime::grips);
}

TEST(ElasticRebound, IsMirroredToTheLastBit) {
  std::mt19937_64 engine(34);
  for (int i = 0; i < 500; ++i) {
    const Drawn d = drawn(engine);
    const Motion mirrored{-d.touchdown.vx_mps, d.touchdown.vy_mps, -d.touchdown.omega_radps};
    const Rebound one = rebound(d.ball, d.touchdown, d.c), other = rebound(d.ball, mirrored, d.c);
    CHECK(one.lift_off.vx_mps == -other.lift_off.vx_mps);
    CHECK(one.lift_off.omega_radps == -other.lift_off.omega_radps);
  }
}

// Rounding of the sums of squares, 1e-14 of what was there.
TEST(ElasticRebound, NeverCreatesEnergyNorBreaksCoulombsLawOrTheBalanceOfAngularMomentum) {
  std::mt19937_64 engine(1976);
  for (int i = 0; i < 20000; ++i) {
    const Drawn d = drawn(engine);
    const Rebound out = rebound(d.ball, d.touchdown, d.c);
    const double before = tangential_energy(d.ball, d.touchdown);
    CHECK(tangential_energy(d.ball, out.lift_off) <= before * (1.0 + 1e-13));
    CHECK(std::abs(out.impulse_ratio) <= d.c.mu * (1.0 + 1e-13));
    const double radius = d.ball.diameter_m / 2.0, scale = std::abs(d.touchdown.vx_mps) + radius * 2000.0;
    DOUBLES_EQUAL(out.lift_off.vx_mps - d.touchdown.vx_mps,
                  d.ball.alpha * radius * (out.lift_off.omega_radps - d.touchdown.omega_radps), 1e-13 * scale);
    DOUBLES_EQUAL(out.slip_lo_mps, slip(d.ball, out.lift_off), 1e-13 * scale);
  }
}

// At e = 1 the normal spring has no loss and the law is that of the contact mechanics without dashpots and offset, which
// Dormand–Prince integrates to 1e-11 of each motion; a hundredfold for grips that graze their limit.
TEST(ElasticRebound, AtFullRestitutionIsTheContactMechanicsWithoutDashpots) {
  std::mt19937_64 engine(1981);
  for (int i = 0; i < 1000; ++i) {
    Drawn d = drawn(engine);
    d.c.e = 1.0;
    d.c.stiffness_ratio *= d.c.stiffness_ratio;  // .05 to 55: up to 60 changes of grip and slip
    const auto reference = simulate(d.ball, d.touchdown,
                                    {.e = 1.0, .dwell_s = 1e-5, .mu = d.c.mu, .stiffness_ratio = d.c.stiffness_ratio,
                                     .damping_ratio = 0.0, .offset_share = 0.0},
                                    {.method = ContactMethod::dormand_prince, .tolerance = 1e-11});
    CHECK(reference.has_value());
    const double scale = std::abs(slip(d.ball, d.touchdown)) + 3.0 * d.c.mu * -d.touchdown.vy_mps;
    DOUBLES_EQUAL(reference->slip_lo_mps, rebound(d.ball, d.touchdown, d.c).slip_lo_mps, 1e-9 * scale);
  }
}

// Return mapping is of first order where grip and slip change: 20,000 steps leave 1e-3 at most, mostly 1e-6.
TEST(ElasticRebound, BelowFullRestitutionIsTheStatedLawInSmallSteps) {
  std::mt19937_64 engine(2000);
  for (int i = 0; i < 300; ++i) {
    const Drawn d = drawn(engine);
    const double scale = std::abs(slip(d.ball, d.touchdown)) + 3.0 * d.c.mu * -d.touchdown.vy_mps;
    DOUBLES_EQUAL(stepped_slip_lo(d, 20000), rebound(d.ball, d.touchdown, d.c).slip_lo_mps, 1e-4 * scale);
  }
}

// What the header says of the annuli's solution: equal from psi1 = 4·chi - 1 on, nowhere further apart in vx than
// 0.11·mu·|vy|. 100 springs and 1,000 steps are good to 1e-3 of psi.
TEST(ElasticRebound, IsNearTheSolutionOfTheWholeFootprint) {
  for (const double nu : {0.0, 0.23, 0.3, 0.5}) {
    const double kappa = mindlin_stiffness_ratio(nu), chi = kappa * 3.5 / 2.0, mu = 0.1;
    for (double psi = 0.2; psi < 4.0 * chi + 1.0; psi += 0.2) {
      const double w = psi * mu / kappa;
      const double whole = testing::footprint_slip_lo({.slip = w, .mu = mu, .kappa = kappa}, 100, 1000);
      const double lumped = rebound(kSphere, {w, -1.0, 0.0}, {.mu = mu, .stiffness_ratio = kappa}).slip_lo_mps;
      DOUBLES_EQUAL(whole, lumped, (psi > 4.0 * chi - 1.0 ? 0.002 : 0.11 * 3.5) * mu);
    }
  }
}

TEST(ElasticRebound, RefusesWhatItIsNotMadeFor) {
  const Motion touchdown{1.0, -1.0, 0.0};
  const auto refusal = [&](const ball::Ball& ball, const Motion& motion, const ElasticCoefficients& c) {
    const auto out = elastic_rebound(ball, motion, c);
    return out ? std::string() : std::string(message(out.error()));
  };
  CHECK_EQUAL(std::string(message(InputError::friction_negative)), refusal(kSphere, touchdown, {.mu = -0.1}));
  CHECK_EQUAL(std::string(message(InputError::not_approaching)), refusal(kSphere, {1.0, 1.0, 0.0}, {.mu = 0.1}));
  for (const double ratio : {0.9e-3, 1.1e3, std::numeric_limits<double>::quiet_NaN()})
    CHECK_EQUAL(std::string(message(InputError::spring_out_of_range)),
                refusal(kSphere, touchdown, {.mu = 0.1, .stiffness_ratio = ratio}));
  CHECK_EQUAL(std::string(message(InputError::restitution_out_of_range)), refusal(kSphere, touchdown, {.e = 1.01}));
}
