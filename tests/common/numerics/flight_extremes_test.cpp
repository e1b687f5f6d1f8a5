// Flight, ball and contact with whatever is put in: a typed error, nothing, or finite numbers, and no
// floating-point exception on the way. A failure prints what was drawn and the seed that repeats it.
#include <array>

#include "common/ball/ball.hpp"
#include "common/contact/integration/spin_pulse.hpp"
#include "common/contact/standard_error.hpp"
#include "common/flight/aerodynamics.hpp"
#include "common/flight/parabola.hpp"
#include "common/units/angles.hpp"
#include "tests/common/numerics/any_number.hpp"
#include "tests/support/floating_point_traps.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using strobe::numerics::finite;
using strobe::numerics::hostile;
using strobe::numerics::ordinary;
using strobe::testing::raises_exception;

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
  const double value = *rc::gen::inRange(0, 4) == 0 ? kEnds[*rc::gen::inRange<std::size_t>(0, kEnds.size())]
                                                    : ordinary(low, high);
  RC_LOG() << value << ' ';
  return value;
}

}  // namespace

TEST_GROUP(FlightExtremes){};

TEST(FlightExtremes, Ball) {
  CHECK(rc::check("ball", [] {
    const ball::Ball b{hostile(0.02, 0.2), hostile(0.01, 0.2), hostile(0.1, 0.66)};
    const double inner = hostile(0.0, 0.03);
    check_finite([&] {
      const auto checked = ball::check(b);
      const auto thick = ball::thick_shell_inertia_kgm2(b.mass_kg, b.diameter_m, inner);
      return (!checked || finite(checked->radius_m(), checked->inertia_kgm2())) && (!thick || finite(*thick));
    });
  }));
}

TEST(FlightExtremes, Angles) {
  CHECK(rc::check("angles", [] {
    const double angle = hostile(-1e4, 1e4);
    RC_PRE(std::isfinite(angle) && std::abs(angle) < 1e300);
    check_finite([&] {
      return std::abs(wrap_half_turn(angle)) <= kPi / 2 && std::abs(wrap_turn(angle)) <= kPi &&
             finite(degrees(angle), radians(angle));
    });
  }));
}

TEST(FlightExtremes, Parabola) {
  CHECK(rc::check("parabola", [] {
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
  CHECK(rc::check("forcing", [] {
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
  CHECK(rc::check("SpinPulse", [] {
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
  CHECK(rc::check("fit_fractions, pulse_standard_errors", [] {
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
