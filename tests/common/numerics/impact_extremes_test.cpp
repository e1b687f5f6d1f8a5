// Whatever the inputs: a typed error or finite numbers, and no floating-point exception on the way. A failure
// prints the seed that repeats it (RC_PARAMS).
#include "common/impact/closed_form/pulse_integrals.hpp"
#include "common/impact/closed_form/sine_pulse.hpp"
#include "common/impact/fit/rebound_model.hpp"
#include "common/impact/ode/contact_ode.hpp"
#include "common/impact/ode/normal_spring.hpp"
#include "tests/common/numerics/any_number.hpp"
#include "tests/support/floating_point_traps.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::impact;
using strobe::numerics::finite;
using strobe::numerics::hostile;
using strobe::testing::raises_exception;

namespace {

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
  CHECK(rc::check("rigid, grip", [] {
    const ball::Ball ball = any_ball();
    const Motion m = any_touchdown();
    const Coefficients c = any_coefficients();
    const auto sound = [](const Rebound& r) { return is_finite(r); };
    check([&] { return grip(ball, m, c); }, sound);
    check([&] { return rigid(ball, m, c.e, c.mu); }, sound);
  }));
}

TEST(ImpactExtremes, ModelsByTheirParameters) {
  CHECK(rc::check("rebound_of", [] {
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
  CHECK(rc::check("SinePulse", [] {
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
  CHECK(rc::check("pulse_rebound", [] {
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

TEST(ImpactExtremes, PulseIntegrals) {
  CHECK(rc::check("pulse_integrals", [] {
    const double f = hostile(0.0, 10.0), theta = hostile(0.0, 3.1415);
    check([&] { return pulse_integrals(f, theta); },
          [](const PulseIntegrals& i) { return finite(i.impulse, i.displacement, i.depth); });
  }));
  CHECK_EQUAL(InputError::phase_out_of_range, pulse_integrals(10.1, 1.0).error());
  CHECK_EQUAL(InputError::phase_out_of_range, pulse_integrals(-0.1, 1.0).error());
  CHECK_EQUAL(InputError::phase_out_of_range, pulse_integrals(0.1, 3.15).error());
  CHECK_EQUAL(InputError::not_finite, pulse_integrals(0.1, NAN).error());
}

TEST(ImpactExtremes, ContactSpring) {
  CHECK(rc::check("normal_spring", [] {
    const double mass = hostile(0.01, 0.2), e = hostile(0.0, 1.0), dwell = hostile(1e-6, 1.0);
    check([&] { return damping_ratio_from_restitution(e); }, [](double zeta) { return finite(zeta); });
    check([&] { return normal_spring(mass, e, dwell); },
          [](const NormalSpring& s) {
            return finite(s.stiffness_npm, s.damping_nspm, s.damping_ratio, s.frequency_radps);
          });
  }));
}

TEST(ImpactExtremes, IntegratedContact) {
  CHECK(rc::check("simulate", [] {
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
