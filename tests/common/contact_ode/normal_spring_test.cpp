#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <complex>
#include <limits>

#include "common/impact/ode/normal_spring.hpp"
#include "common/impact/ode/segment_nodes.hpp"
#include "tests/common/contact_ode/reference.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe::impact;
using strobe::testing::Quad;

TEST_GROUP(NormalSpring){};

TEST(NormalSpring, RestitutionAndReleaseOfADampingRatioHoldThirteenDigits) {
  for (double zeta = 1e-12; zeta < 0.99999; zeta = zeta < 0.1 ? zeta * 3.7 : zeta + 0.0137) {
    const Quad phase = strobe::testing::reference_release_phase(zeta);
    const Quad e = exp(-Quad(zeta) * phase);
    DOUBLES_EQUAL(1.0, static_cast<double>(release_phase(zeta) / phase), 1e-13);
    DOUBLES_EQUAL(1.0, static_cast<double>(restitution_of_damping_ratio(zeta) / e), 1e-13);
  }
}

TEST(NormalSpring, BeyondCriticalDampingItReleasesWhereTheForceIsGone) {
  for (const double zeta : {1.0 + 1e-9, 1.0001, 1.01, 1.5, 4.0, 15.0}) {
    const Quad p = sqrt(Quad(zeta) * zeta - 1);
    const Quad t = release_phase(zeta);
    // N = y + 2 zeta y' of y = exp(-zeta t) sinh(p t)/p, over its first term.
    const Quad ratio = 1 + 2 * zeta * (p / tanh(p * t) - zeta);
    // A part in 1e15 of zeta·t moves exp(-zeta·t) by that and the zero by as much times zeta².
    DOUBLES_EQUAL(0.0, static_cast<double>(ratio), 1e-14 * zeta * zeta * zeta * zeta + 1e-13);
  }
}

TEST(NormalSpring, DampingRatioOfARestitutionHoldsThirteenDigits) {
  for (const double e :
       {1.0 - 1e-15, 1.0 - 1e-9, 0.9999, 0.97, 0.86, 0.71, 0.5, 0.38, 0.36, 0.3, 0.2, 0.15, 0.14}) {
    const Quad reference = strobe::testing::reference_damping_ratio(e);
    // Of an e near 1 only 1 - e carries digits: relative to zeta the last bit of e is worth eps/(1 - e).
    const double tolerance = 1e-13;
    DOUBLES_EQUAL(1.0, static_cast<double>(*damping_ratio_from_restitution(e) / reference), tolerance);
  }
}

TEST(NormalSpring, TheInverseReturnsToItsRestitutionOnBothSidesOfCriticalDamping) {
  for (double e = kMinSpringRestitution; e <= 1.0; e += 0.00311) {
    const double zeta = *damping_ratio_from_restitution(e);
    DOUBLES_EQUAL(1.0, restitution_of_damping_ratio(zeta) / e, 2e-14);
  }
  DOUBLES_EQUAL(1.0, *damping_ratio_from_restitution(std::exp(-2.0)), 1e-14);
}

TEST(NormalSpring, StiffnessOfAnUndampedSpringIsThatOfHalfAnOscillation) {
  const auto spring = normal_spring(0.0576, 1.0, 5e-3);
  DOUBLES_EQUAL(0.0576 * std::pow(3.14159265358979324 / 5e-3, 2), spring->stiffness_npm, 1e-8);
  DOUBLES_EQUAL(0.0, spring->damping_nspm, 0.0);
}

TEST(NormalSpring, InputsOutOfRangeAreNamed) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto error_of = [](double mass, double e, double dwell) {
    return normal_spring(mass, e, dwell).error();
  };
  CHECK_EQUAL(InputError::not_finite, error_of(nan, 0.5, 1.0));
  CHECK_EQUAL(InputError::not_finite, error_of(1.0, nan, 1.0));
  CHECK_EQUAL(InputError::ball_out_of_range, error_of(-1.0, 0.5, 1.0));
  CHECK_EQUAL(InputError::restitution_out_of_range, error_of(1.0, 1.1, 1.0));
  CHECK_EQUAL(InputError::spring_out_of_range, error_of(1.0, 1e-4, 1.0));
  CHECK_EQUAL(InputError::dwell_not_positive, error_of(1.0, 0.5, 0.0));
  CHECK_EQUAL(InputError::magnitude_out_of_range, error_of(1.0, 0.5, 1e-300));
}

// The damped oscillation's series against its closed forms in long double.
using strobe::impact::detail::DampedSeries;

namespace {

using Complex = std::complex<long double>;

/// Of v'' + 2b·v' + f·v = 0: S and its rate, by the roots of the characteristic polynomial.
std::array<long double, 2> closed_form(double b, double f, double t) {
  const Complex root = std::sqrt(Complex(static_cast<long double>(b) * b - f));
  const Complex up = std::exp((-Complex(b) + root) * Complex(t));
  const Complex down = std::exp((-Complex(b) - root) * Complex(t));
  const Complex sine = (up - down) / (2.0L * root);
  const Complex rate = ((-Complex(b) + root) * up - (-Complex(b) - root) * down) / (2.0L * root);
  return {sine.real(), rate.real()};
}

struct Damping {
  double b, f;
};
constexpr Damping kDampings[] = {{0.0, 1.0}, {0.05, 1.0}, {0.9, 1.0}, {1.2, 1.0}, {3.0, 4.0}, {0.4, 9.0}};

/// Largest error of both over 0…longest, relative to 1 and to the fastest speed.
template <std::size_t terms>
double worst_error(const Damping& d, double longest) {
  const DampedSeries<terms> series(d.b, d.f);
  std::array<double, 8> times, sine, rate;
  for (std::size_t i = 0; i < 8; ++i) times[i] = longest * static_cast<double>(i + 1) / 8.0;
  series.along(times, longest, sine, rate);
  double worst = 0.0;
  for (std::size_t i = 0; i < 8; ++i) {
    const auto exact = closed_form(d.b, d.f, times[i]);
    worst = std::max({worst, std::abs(static_cast<double>(sine[i] - exact[0])) * std::sqrt(d.f),
                      std::abs(static_cast<double>(rate[i] - exact[1]))});
  }
  return worst;
}

}  // namespace

TEST_GROUP(DampedSeries){};

// Up to four doublings, each of which makes a relative error twice as large: 16 times some roundings of the series.
TEST(DampedSeries, KeepsTheDigitsOfTheClosedFormsWhateverTheDamping) {
  for (const Damping& d : kDampings)
    for (const double longest : {0.01, 0.7, 3.1}) CHECK(worst_error<17>(d, longest) < 16 * 4 * 2.3e-16);
}

// 0.8^terms/terms! of the first term, twice per doubling.
TEST(DampedSeries, OfFewerTermsIsAsGoodAsTheFirstThatIsLeftOut) {
  for (const Damping& d : kDampings) {
    CHECK(worst_error<9>(d, 3.1) < 16 * 4e-7);
    CHECK(worst_error<12>(d, 3.1) < 16 * 1.5e-10);
    CHECK(worst_error<15>(d, 3.1) < 16 * 3e-14);
  }
}

TEST(DampedSeries, ExponentialsAreThoseOfTheLibrary) {
  for (const double speed : {-7.0, -0.3, 0.0, 0.5, 4.0}) {
    const std::array<double, 4> times{0.1, 0.9, 1.7, 3.1};
    std::array<double, 4> got;
    DampedSeries<17>::exponentials(speed, times, 3.1, got);
    for (std::size_t i = 0; i < 4; ++i) {
      const double exact = std::exp(speed * times[i]);
      DOUBLES_EQUAL(exact, got[i], 32 * 4 * 2.3e-16 * exact);
    }
  }
}
