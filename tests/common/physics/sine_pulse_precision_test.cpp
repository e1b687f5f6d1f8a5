// The pulse in double precision against its defining formulas in 50 digits.
#include <boost/math/constants/constants.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "common/impact/closed_form/sine_pulse.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::impact;

namespace {

// A hundred digits: fifty are left where the formulas cancel most (theta³/6 at theta = 3e-15).
using Wide = boost::multiprecision::cpp_bin_float_100;
const Wide kPi = boost::math::constants::pi<Wide>();

Wide wide_damping(PulseForm form, double e_double) {
  const Wide e = e_double;
  if (form == PulseForm::simplified) return -log(e) / kPi;
  Wide f = 0;  // Newton: e(f) falls and is convex, so it rises to the root
  for (int i = 0; i < 60; ++i) {
    const Wide decay = exp(-f * kPi), q = 1 + f * f;
    const Wide miss = (1 + decay) / q - 1 - e;
    const Wide slope = -kPi * decay / q - 2 * f * (1 + decay) / (q * q);
    f -= miss / slope;
    if (abs(miss) < Wide(1e-95)) break;
  }
  return f;
}

struct WideState {
  Wide vx, vy, x, y, fy, impulse;
};

WideState wide_state(PulseForm form, const PulseInput& in, const Wide& f, double tau) {
  const Wide speed = -Wide(in.vy_td_mps), w = kPi / Wide(in.dwell_s), theta = kPi * Wide(tau);
  const Wide decay = exp(-f * theta), s = sin(theta), c = cos(theta), q = 1 + f * f;
  const Wide ratio = in.impulse_ratio, t = Wide(tau) * Wide(in.dwell_s), vx = in.vx_td_mps;
  WideState out;
  out.fy = Wide(in.mass_kg) * speed * w * decay * s;
  if (form == PulseForm::exact) {
    const Wide i1 = (1 - decay * (f * s + c)) / q;
    const Wide i2 = theta / q - (decay * ((1 - f * f) * s - 2 * f * c) + 2 * f) / (q * q);
    out.vx = vx - ratio * speed * i1;
    out.vy = speed * (i1 - 1);
    out.y = speed / w * (i2 - theta);
    out.x = vx * t - ratio * (speed / w) * i2;
    out.impulse = i1 / (1 + Wide(in.e));
  } else {
    out.vx = vx + ratio * speed * (decay * c - 1);
    out.vy = -speed * decay * c;
    out.y = -(speed / w) * decay * s;
    out.x = (vx - ratio * speed) * t + ratio * speed / w * decay * s;
    out.impulse = (1 - decay * c) / (1 + Wide(in.e));
  }
  return out;
}

/// |got - want| over the larger of |want| and `scale`; 50 digits minus the worst cancellation are left in
/// `want`.
double error(double got, const Wide& want, const Wide& scale) {
  const Wide size = abs(want) > scale ? Wide(abs(want)) : scale;
  return size == 0 ? std::abs(got) : static_cast<double>(abs(got - want) / size);
}

/// Largest error of all outputs. Positions, force and impulse: relative to themselves. Velocities: to the
/// speeds at touchdown, since they pass through zero. x: to the terms of its difference, for the same reason.
double worst_error(PulseForm form, const PulseInput& in, const Wide& f, double tau) {
  const PulseState got = SinePulse::make(form, in)->at_fraction(tau);
  const WideState want = wide_state(form, in, f, tau);
  const Wide vx_scale = abs(Wide(in.vx_td_mps)) + abs(Wide(in.impulse_ratio) * in.vy_td_mps);
  const Wide x_scale = abs(Wide(in.vx_td_mps)) * tau * in.dwell_s;
  const Wide nothing = Wide(1e-40);  // sin(pi) and 1 - 1 in 50 digits are not quite zero
  double worst = error(got.vx_mps, want.vx, vx_scale);
  worst = std::max(worst, error(got.vy_mps, want.vy, -Wide(in.vy_td_mps)));
  worst = std::max(worst, error(got.x_m, want.x, x_scale));
  worst = std::max(worst, error(got.y_m, want.y, nothing));
  worst = std::max(worst, error(got.fy_n, want.fy, nothing));
  return std::max(worst, error(got.impulse_fraction, want.impulse, nothing));
}

constexpr double kRestitutions[] = {1.0, 1.0 - 1e-15, 1.0 - 1e-12, 1.0 - 1e-8, 1.0 - 1e-4, 0.95, 0.865,
                                    0.7, 0.5,         0.1,         1e-3,       1e-9,       0.0};
constexpr double kFractions[] = {0.0,  1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.1,        0.25,        0.3183,
                                 0.32, 0.4,   0.5,   0.51, 0.7,  0.9,  0.99, 1.0 - 1e-6, 1.0 - 1e-12, 1.0};
constexpr double kTolerance = 1e-13;

}  // namespace

TEST_GROUP(SinePulsePrecision){};

TEST(SinePulsePrecision, DampingAgreesWithFiftyDigits) {
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    for (const double e : kRestitutions) {
      if (e == 0.0 && form == PulseForm::simplified) continue;
      const double worst = error(*damping_from_restitution(form, e), wide_damping(form, e), Wide(1e-40));
      CHECK_TEXT(worst < kTolerance, (std::to_string(e) + " " + std::to_string(worst)).c_str());
    }
  }
}

TEST(SinePulsePrecision, StatesAgreeWithFiftyDigitsAtTheEdges) {
  for (const PulseForm form : {PulseForm::exact, PulseForm::simplified}) {
    for (const double e : kRestitutions) {
      if (e == 0.0 && form == PulseForm::simplified) continue;
      const Wide f = wide_damping(form, e);
      for (const double ratio : {0.0, 0.55, -0.2}) {
        for (const double vx : {0.0, 15.62}) {
          for (const double tau : kFractions) {
            const double worst = worst_error(form, {vx, -6.701, e, ratio, 5.1996e-3}, f, tau);
            char where[120];
            std::snprintf(where, sizeof where, "form %d e %.17g ratio %g vx %g tau %.17g: error %g",
                          static_cast<int>(form), e, ratio, vx, tau, worst);
            CHECK_TEXT(worst < kTolerance, where);
          }
        }
      }
    }
  }
}

TEST(SinePulsePrecision, StatesAgreeWithFiftyDigitsAtRandom) {
  const unsigned seed = 20260101;
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  double worst = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const PulseForm form = i % 2 == 0 ? PulseForm::exact : PulseForm::simplified;
    const PulseInput in{uniform(0.0, 40.0), uniform(-40.0, -0.1), uniform(0.01, 1.0), uniform(0.0, 1.0),
                        uniform(1e-3, 1e-2)};
    worst = std::max(worst, worst_error(form, in, wide_damping(form, in.e), std::pow(uniform(0.0, 1.0), 2)));
  }
  CHECK_TEXT(worst < kTolerance,
             ("seed " + std::to_string(seed) + ": error " + std::to_string(worst)).c_str());
}
