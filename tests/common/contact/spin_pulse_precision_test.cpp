// The pulse carried to spin, in double precision, against quadrature of its forces in 50 digits.
#include <boost/math/constants/constants.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>

#include "common/contact/integration/spin_pulse.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using contact::SpinPulse;
using contact::SpinPulseInput;
using contact::SpinPulseState;

namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Gauss = boost::math::quadrature::gauss<Wide, 30>;  // of an entire function over a phase of at most pi
const Wide kPi = boost::math::constants::pi<Wide>();

/// exp(-f·phi)·sin(phi), the force's shape; f as the restitution's root in 50 digits.
struct Shape {
  Wide f;
  Wide force(const Wide& phi) const { return exp(-f * phi) * sin(phi); }
  Wide impulse(const Wide& from, const Wide& to) const {
    return Gauss::integrate([this](const Wide& phi) { return force(phi); }, from, to);
  }
  /// What the impulse of from…to has moved by the phase `end`.
  Wide moment(const Wide& from, const Wide& to, const Wide& end) const {
    return Gauss::integrate([this, &end](const Wide& phi) { return Wide((end - phi) * force(phi)); }, from,
                            to);
  }
};

template <typename Function>
Wide root(const Function& function, const Wide& low, const Wide& high) {
  std::uintmax_t steps = 200;
  const auto bracket = boost::math::tools::toms748_solve(function, low, high,
                                                         boost::math::tools::eps_tolerance<Wide>(160), steps);
  return (bracket.first + bracket.second) / 2;
}

Wide wide_damping(double e) {
  if (e == 1.0) return 0;  // e falls from 1 to below 0 over f = 0…1/2
  return root([e](const Wide& f) { return Wide((1 + exp(-f * kPi)) / (1 + f * f) - 1 - e); }, 0, Wide(1) / 2);
}

struct WideState {
  Wide x, rotation, vx, omega, slip;
  Wide x_scale, rotation_scale, vx_scale, omega_scale;  // sums of the magnitudes of what acts
};

struct Reference {
  explicit Reference(const SpinPulseInput& input) : in(input), shape{wide_damping(input.e)} {
    radius = Wide(in.ball.diameter_m) / 2;
    alpha = in.ball.alpha;
    speed = -Wide(in.touchdown.vy_mps);
    const Wide slip = in.touchdown.vx_mps + radius * Wide(in.touchdown.omega_radps);
    slipping = slip < 0 ? -Wide(in.mu) : Wide(in.mu);
    rolling = Wide(in.offset_m) / (radius * (1 + alpha));
    if (rolling > in.mu) rolling = in.mu;
    if (rolling < -in.mu) rolling = -Wide(in.mu);
    find_grip(slip);
  }

  /// Where the slip, found by quadrature, passes through zero.
  void find_grip(const Wide& slip) {
    const auto left = [&](const Wide& phi) {
      return Wide(slip - speed * shape.impulse(0, phi) *
                             ((1 + alpha) * slipping - Wide(in.offset_m) / radius) / alpha);
    };
    grip = slip == 0 ? Wide(0) : kPi;
    if (slip == 0 || (left(kPi) > 0) == (slip > 0)) return;
    grip = root(left, 0, kPi);
  }

  WideState at(double tau) const {
    const Wide end = kPi * Wide(tau), t = Wide(tau) * Wide(in.dwell_s), length = speed * in.dwell_s / kPi;
    const Wide turn = end < grip ? end : grip;
    const Wide i_before = shape.impulse(0, turn), i_after = shape.impulse(turn, end);
    const Wide m_before = shape.moment(0, turn, end), m_after = shape.moment(turn, end, end);
    const Wide lever = Wide(in.offset_m) / radius;
    const Wide vx0 = in.touchdown.vx_mps, omega0 = in.touchdown.omega_radps;
    WideState s;
    const Wide friction = speed * (slipping * i_before + rolling * i_after);
    const Wide drag = length * (slipping * m_before + rolling * m_after);
    const Wide push = lever * speed * (i_before + i_after), shove = lever * length * (m_before + m_after);
    s.vx = vx0 - friction;
    s.x = vx0 * t - drag;
    s.omega = omega0 + (push - friction) / (alpha * radius);
    s.rotation = omega0 * t + (shove - drag) / (alpha * radius);
    s.slip = s.vx + radius * s.omega;
    s.vx_scale = abs(vx0) + abs(friction);
    s.x_scale = abs(vx0 * t) + abs(drag);
    s.omega_scale = abs(omega0) + (abs(push) + abs(friction)) / (alpha * radius);
    s.rotation_scale = abs(omega0 * t) + (abs(shove) + abs(drag)) / (alpha * radius);
    return s;
  }

  SpinPulseInput in;
  Shape shape;
  Wide radius, alpha, speed, slipping, rolling, grip;
};

double relative(double got, const Wide& want, const Wide& scale) {
  return scale == 0 ? std::abs(got) : static_cast<double>(abs(got - want) / scale);
}

double worst_error(const SpinPulse& pulse, const Reference& reference, double tau) {
  const SpinPulseState got = pulse.at_fraction(tau);
  const WideState want = reference.at(tau);
  double worst = relative(got.x_m, want.x, want.x_scale);
  worst = std::max(worst, relative(got.rotation_rad, want.rotation, want.rotation_scale));
  worst = std::max(worst, relative(got.vx_mps, want.vx, want.vx_scale));
  worst = std::max(worst, relative(got.omega_radps, want.omega, want.omega_scale));
  const Wide slip_scale = want.vx_scale + reference.radius * want.omega_scale;
  return std::max(worst, relative(got.slip_mps, want.slip, slip_scale));
}

constexpr double kTolerance = 1e-13;

void check(const Reference& reference, double tau, double& worst) {
  const SpinPulseInput& in = reference.in;
  const auto pulse = SpinPulse::make(in);
  CHECK(pulse.has_value());
  const double error = worst_error(*pulse, reference, tau);
  worst = std::max(worst, error);
  if (error < kTolerance) return;
  char where[300];
  std::snprintf(where, sizeof where,
                "vx %.17g vy %.17g omega %.17g e %.17g mu %.17g alpha %g offset %g dwell %g tau %.17g: %g",
                in.touchdown.vx_mps, in.touchdown.vy_mps, in.touchdown.omega_radps, in.e, in.mu,
                in.ball.alpha, in.offset_m, in.dwell_s, tau, error);
  FAIL(where);
}

}  // namespace

TEST_GROUP(SpinPulsePrecision){};

TEST(SpinPulsePrecision, AgreesWithFiftyDigitQuadratureAtTheEdges) {
  double worst = 0.0;
  for (const double e : {1.0, 1.0 - 1e-12, 0.86, 0.3, 0.0}) {
    for (const double mu : {0.0, 1e-9, 0.55, 10.0}) {
      for (const double omega : {-1e5, -479.87711, 0.0, 165.0}) {  // the second nearly rolls
        for (const double offset : {0.0, 0.0025, -0.03}) {
          const SpinPulseInput in{.ball = {},
                                  .touchdown = {15.62, -6.7, omega},
                                  .e = e,
                                  .mu = mu,
                                  .dwell_s = 5.2e-3,
                                  .offset_m = offset};
          const Reference reference(in);
          for (const double tau : {0.0, 1e-12, 1e-5, 0.03, 0.5, 0.97, 1.0}) check(reference, tau, worst);
        }
      }
    }
  }
}

TEST(SpinPulsePrecision, AgreesWithFiftyDigitQuadratureOverTheWholeRangeAtRandom) {
  const unsigned seed = 20261121;
  std::mt19937_64 random(seed);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto decades = [&](double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  };
  double worst = 0.0;
  for (int i = 0; i < 500; ++i) {
    SpinPulseInput in;
    in.ball.alpha = uniform(0.3, 2.0 / 3.0);
    const double speed = decades(1e-6, 1e3), angle = decades(1e-4, 1.5);
    in.touchdown = {speed * std::cos(angle), -speed * std::sin(angle), 0.0};
    // Half of the spins within a factor of rolling, half anywhere.
    in.touchdown.omega_radps = i % 2 == 0 ? uniform(-2.0, 2.0) * in.touchdown.vx_mps / in.ball.radius_m()
                                          : (i % 4 == 1 ? -1.0 : 1.0) * decades(1e-3, 1e5);
    in.e = i % 5 == 0 ? 1.0 - decades(1e-15, 0.1) : uniform(0.0, 1.0);
    in.mu = i % 3 == 0 ? decades(1e-6, 10.0) : uniform(0.0, 1.0);
    in.dwell_s = decades(1e-6, 1.0);
    in.offset_m = i % 4 == 0 ? 0.0 : uniform(-0.03, 0.03);
    check(Reference(in), i % 2 == 0 ? uniform(0.0, 1.0) : decades(1e-9, 1.0), worst);
  }
  std::printf("spin pulse: worst error %.2g, seed %u\n", worst, seed);
}
