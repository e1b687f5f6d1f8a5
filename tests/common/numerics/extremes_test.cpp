// Whatever the inputs: a typed error or finite numbers, and no floating-point exception on the way. A failure
// prints the seed that repeats it (RC_PARAMS).
#include <rapidcheck.h>
#include <cmath>
#include <limits>
#include <vector>
#include <array>

#include "common/ball/ball.hpp"
#include "common/contact/spin_pulse.hpp"
#include "common/contact/standard_error.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/flight/parabola.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/fit/rebound_model.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "common/units/angles.hpp"
#include "tests/support/floating_point_traps.hpp"
#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::impact;
using strobe::testing::holds_of_all;
using strobe::testing::raises_exception;

namespace {

/// Values at which arithmetic changes: of either sign.
const std::vector<double>& extremes() {
  static const std::vector<double> all = [] {
    using Limits = std::numeric_limits<double>;
    std::vector<double> values{0.0,
                               Limits::denorm_min(),
                               1e-310,
                               Limits::min(),
                               1e-200,
                               1e-155,
                               1e-60,
                               1e-31,
                               1e-30,
                               1e-15,
                               1.0,
                               1e15,
                               1e30,
                               1.1e30,
                               1e60,
                               1e154,
                               1e155,
                               1e200,
                               1e307,
                               Limits::max(),
                               Limits::infinity(),
                               Limits::quiet_NaN()};
    const std::size_t count = values.size();
    for (std::size_t i = 0; i < count; ++i) values.push_back(-values[i]);
    return values;
  }();
  return all;
}

/// An ordinary value of low…high, both ends included.
double ordinary(double low, double high) {
  return strobe::testing::between(low, high);
}

/// One time in `rarity` an extreme, else an ordinary value. A failure prints what was drawn, in order.
double hostile(double low, double high, int rarity = 8) {
  double value = ordinary(low, high);
  if (strobe::testing::one_in(rarity)) {
    const auto& all = extremes();
    value = all[*rc::gen::inRange<std::size_t>(0, all.size())];
  }
  RC_LOG() << value << ' ';
  return value;
}

template <typename... T>
bool finite(T... values) {
  return (std::isfinite(values) && ...);
}

ball::Ball any_ball() { return {hostile(0.02, 0.2, 20), hostile(0.01, 0.2, 20), hostile(0.1, 0.66, 20)}; }

Motion any_touchdown() { return {hostile(-40.0, 40.0), hostile(-40.0, 0.0), hostile(-1e3, 1e3)}; }

Coefficients any_coefficients() {
  return {hostile(0.0, 1.0, 20), hostile(0.0, 1.5), hostile(-1.0, 1.0, 20), hostile(0.0, 0.02),
          hostile(0.01, 10.0)};
}

PulseForm any_form() { return *rc::gen::arbitrary<bool>() ? PulseForm::exact : PulseForm::simplified; }

bool is_finite(const Motion& m) { return finite(m.vx_mps, m.vy_mps, m.omega_radps); }

bool is_finite(const Rebound& r) {
  return is_finite(r.lift_off) && finite(r.slip_lo_mps, r.impulse_ratio, r.offset_m);
}

/// Calls without traps, so that a failure is reported with its arguments, then with them.
template <typename Call, typename IsFinite>
void check(Call&& call, IsFinite&& all_finite) {
  RC_ASSERT_FALSE(raises_exception([&] {
    const auto result = call();
    static_cast<void>(result);
  }));
  const strobe::testing::FloatingPointTraps traps;
  const auto result = call();
  const bool sound = !result || all_finite(*result);  // rapidcheck evaluates either side of an || of its own
  RC_ASSERT(sound);
}

}  // namespace

TEST_GROUP(ImpactExtremes){};

TEST(ImpactExtremes, InOutModels) {
  CHECK(holds_of_all([] {
    const ball::Ball ball = any_ball();
    const Motion m = any_touchdown();
    const Coefficients c = any_coefficients();
    const auto sound = [](const Rebound& r) { return is_finite(r); };
    check([&] { return grip(ball, m, c); }, sound);
    check([&] { return rigid(ball, m, c.e, c.mu); }, sound);
  }));
}

TEST(ImpactExtremes, ModelsByTheirParameters) {
  CHECK(holds_of_all([] {
    const auto model =
        *rc::gen::element(ReboundModel::slide_roll, ReboundModel::grip, ReboundModel::grip_offset);
    const Coefficients c = any_coefficients();
    const ParameterValues p{c.mu, c.e_x, c.offset_m, c.offset_reference_mps, hostile(0.1, 0.66, 20)};
    const double diameter = hostile(0.02, 0.2, 20);
    const Motion m = any_touchdown();
    check([&] { return rebound_of(model, p, diameter, m, c.e); },
          [](const Rebound& r) { return is_finite(r); });
  }));
}

TEST(ImpactExtremes, PulseAndItsInverse) {
  CHECK(holds_of_all([] {
    const PulseForm form = any_form();
    const PulseInput in{hostile(-40.0, 40.0), hostile(-40.0, 0.0), hostile(0.0, 1.0),
                        hostile(-2.0, 2.0),   hostile(1e-6, 1.0),  hostile(0.01, 0.2)};
    const double fraction =
        *rc::gen::element(0.0, 1e-300, 1e-9, 0.3, 0.5, 0.999999999, 1.0, -0.5, 1.5, 1e300);
    check([&] { return damping_from_restitution(form, in.e); }, [](double f) { return finite(f); });
    check(
        [&] {
          return SinePulse::make(form, in).map([&](const SinePulse& pulse) {
            const PulseState s = pulse.at_fraction(fraction);
            const bool all = finite(s.vx_mps, s.vy_mps, s.x_m, s.y_m, s.fx_n, s.fy_n, s.impulse_fraction) &&
                             finite(pulse.max_force_n(), pulse.fraction_at_impulse(fraction));
            return all ? 1 : 0;
          });
        },
        [](int all) { return all == 1; });
  }));
}

TEST(ImpactExtremes, ReboundThroughThePulse) {
  CHECK(holds_of_all([] {
    const PulseForm form = any_form();
    const ball::Ball ball = any_ball();
    const Motion m = any_touchdown();
    const double e = hostile(0.0, 1.0), mu = hostile(0.0, 1.5), dwell = hostile(1e-6, 1.0);
    check([&] { return pulse_rebound(form, ball, m, e, mu, dwell); },
          [](const PulseRebound& r) {
            return is_finite(r.rebound) &&
                   finite(r.damping_f, r.grip_fraction, r.depth_m, r.dwell_distance_m, r.max_force_n);
          });
  }));
}

TEST(ImpactExtremes, ContactSpring) {
  CHECK(holds_of_all([] {
    const double mass = hostile(0.01, 0.2), e = hostile(0.0, 1.0), dwell = hostile(1e-6, 1.0);
    check([&] { return damping_ratio_from_restitution(e); }, [](double zeta) { return finite(zeta); });
    check([&] { return normal_spring(mass, e, dwell); },
          [](const NormalSpring& s) {
            return finite(s.stiffness_npm, s.damping_nspm, s.damping_ratio, s.frequency_radps);
          });
  }));
}

TEST(ImpactExtremes, IntegratedContact) {
  CHECK(holds_of_all([] {
    const ball::Ball ball = any_ball();
    const Motion m = any_touchdown();
    const ContactCoefficients c{.e = hostile(0.05, 1.0, 20),
                                .dwell_s = hostile(1e-4, 0.1, 20),
                                .mu = hostile(0.0, 1.5, 20),
                                .stiffness_ratio = hostile(0.1, 10.0, 20),
                                .damping_ratio = hostile(0.01, 2.0, 20),
                                .offset_share = hostile(0.0, 1.0, 20),
                                .offset_reference_mps = hostile(0.1, 10.0, 20)};
    check([&] { return simulate(ball, m, c); },
          [](const ContactSummary& s) {
            return is_finite(s.lift_off) &&
                   finite(s.dwell_s, s.max_depth_m, s.max_force_n, s.dwell_distance_m, s.rotation_rad,
                          s.slip_lo_mps, s.energy.dissipated_j());
          });
  }));
}

TEST(ImpactExtremes, NumbersTooLargeToComputeWithAreNamed) {
  CHECK_EQUAL(InputError::magnitude_out_of_range, grip({}, {1e31, -1.0, 0.0}, {}).error());
  CHECK_EQUAL(InputError::magnitude_out_of_range,
              rigid({.diameter_m = 1e-31}, {1.0, -1.0, 0.0}, 0.5, 0.5).error());
  CHECK_EQUAL(InputError::magnitude_out_of_range,
              SinePulse::make(PulseForm::exact, {1.0, -1.0, 0.5, 0.5, 1e-31}).error());
}

// Flight, ball and contact with whatever is put in: a typed error, nothing, or finite numbers, and no
// floating-point exception on the way. A failure prints what was drawn and the seed that repeats it.

namespace {

/// `call` returns whether all that it computed is finite.
template <typename Call>
void check_finite(Call&& call) {
  RC_ASSERT_FALSE(raises_exception([&] { static_cast<void>(call()); }));
  const strobe::testing::FloatingPointTraps traps;
  RC_ASSERT(call());
}

/// Numbers as a caller with checked inputs has them: within 1e-30…1e30, but for zero.
double large_or_small(double low, double high) {
  static constexpr std::array<double, 8> kEnds{0.0, 1e-30, 1e30, -1e-30, -1e30, 1e-15, 1e15, 5e-324};
  const double value = strobe::testing::one_in(4) ? kEnds[*rc::gen::inRange<std::size_t>(0, kEnds.size())]
                                                    : ordinary(low, high);
  RC_LOG() << value << ' ';
  return value;
}

}  // namespace

TEST_GROUP(FlightExtremes){};

TEST(FlightExtremes, Ball) {
  CHECK(holds_of_all([] {
    const ball::Ball b{hostile(0.02, 0.2), hostile(0.01, 0.2), hostile(0.1, 0.66)};
    const double inner = hostile(0.0, 0.03);
    check_finite([&] {
      const auto checked = ball::check(b);
      const auto thick = ball::thick_shell_inertia_kgm2(b.mass_kg, b.diameter_m, inner);
      return (!checked || finite(checked->radius_m(), checked->inertia_kgm2())) && (!thick || finite(*thick));
    });
  }));
}

TEST(ImpactExtremes, PulseIntegrals) {
  CHECK(holds_of_all([] {
    const double f = hostile(0.0, 10.0), theta = hostile(0.0, 3.1415);
    RC_PRE(f >= 0.0 && f <= 10.0 && theta >= 0.0 && theta <= 3.1415);
    check_finite([&] {
      const PulsePhase p = PulsePhase::at_angle(f, theta);
      return finite(impulse_integral(f, p), displacement_integral(f, p), depth_integral(f, p));
    });
  }));
}

TEST(FlightExtremes, Angles) {
  CHECK(holds_of_all([] {
    const double angle = hostile(-1e4, 1e4);
    RC_PRE(std::isfinite(angle) && std::abs(angle) < 1e300);
    check_finite([&] {
      return std::abs(wrap_half_turn(angle)) <= kPi / 2 && finite(degrees(angle), radians(angle));
    });
  }));
}

TEST(FlightExtremes, Parabola) {
  CHECK(holds_of_all([] {
    const flight::Parabola path{{large_or_small(-1.0, 1.0), large_or_small(-1.0, 1.0)},
                                {large_or_small(-40.0, 40.0), large_or_small(-40.0, 40.0)},
                                {large_or_small(-10.0, 10.0), large_or_small(-10.0, 10.0)}};
    const double height = large_or_small(-1.0, 1.0);
    check_finite([&] {
      const auto down = path.time_falling_through_s(height);
      const auto up = path.time_rising_through_s(height);
      return (!down || finite(*down)) && (!up || finite(*up));
    });
  }));
}

TEST(FlightExtremes, DragAndLift) {
  CHECK(holds_of_all([] {
    const ball::Ball ball{ordinary(0.02, 0.2), ordinary(0.01, 0.2), 0.55};
    const Eigen::Vector2d v{large_or_small(-40.0, 40.0), large_or_small(-40.0, 40.0)};
    const double omega = large_or_small(-1e3, 1e3);
    check_finite([&] {
      const auto air = flight::aerodynamics(ball, flight::kAirDensity_kgpm3);
      const auto f = flight::forcing(air, {0.0, -9.8}, v, omega);
      return finite(f.acceleration_mps2.x(), f.acceleration_mps2.y(), f.jerk_mps3.x(), f.jerk_mps3.y());
    });
  }));
}

TEST(FlightExtremes, PulseCarriedThroughToSpin) {
  CHECK(holds_of_all([] {
    contact::SpinPulseInput in;
    in.ball = {hostile(0.02, 0.2, 20), hostile(0.01, 0.2, 20), hostile(0.1, 0.66, 20)};
    in.touchdown = {hostile(-40.0, 40.0), hostile(-40.0, 0.0), hostile(-1e3, 1e3)};
    in.e = hostile(0.0, 1.0);
    in.mu = hostile(0.0, 1.5);
    in.dwell_s = hostile(1e-6, 1.0);
    in.offset_m = hostile(-0.01, 0.01);
    in.form = *rc::gen::arbitrary<bool>() ? impact::PulseForm::exact : impact::PulseForm::simplified;
    const double fraction = ordinary(0.0, 1.0);
    check_finite([&] {
      const auto pulse = contact::SpinPulse::make(in);
      if (!pulse) return true;
      const contact::SpinPulseState s = pulse->at_fraction(fraction);
      return finite(s.x_m, s.y_m, s.rotation_rad, s.vx_mps, s.vy_mps, s.omega_radps, s.slip_mps, s.fx_n,
                    s.fy_n);
    });
  }));
}

TEST(FlightExtremes, ContactAnalysis) {
  CHECK(holds_of_all([] {
    data::ContactSet set{.name = "any", .rows = {{0.0, 0.0, 0.0, 0.0}, {1.0, 1.0, 0.0, 1.0}}};
    const int rows = *rc::gen::inRange(0, 8);
    for (int i = 0; i < rows; ++i)
      set.rows.push_back(
          {ordinary(-0.5, 1.5), large_or_small(0.0, 1.0), large_or_small(-1.0, 0.0), ordinary(-4.0, 4.0)});
    const contact::ContactInputs in{hostile(-40.0, 40.0), hostile(-40.0, 0.0), hostile(0.0, 1.0),
                                    hostile(-2.0, 2.0),   hostile(1e-6, 1.0),  hostile(1e-3, 0.2),
                                    hostile(0.02, 0.2)};
    RC_PRE(std::abs(in.dwell_distance_m) < 1e31 || !finite(in.dwell_distance_m));
    RC_PRE(std::abs(in.diameter_m) < 1e31 || !finite(in.diameter_m));
    check_finite([&] {
      const auto errors = contact::pulse_standard_errors(set, in);
      return !errors || finite(errors->see_x_m, errors->see_y_m);
    });
    check_finite([&] {
      const auto fits = contact::fit_fractions(set);
      return !fits.x || finite(fits.x->value(0.5), fits.x->slope(0.5), fits.x->curvature(0.5));
    });
  }));
}
