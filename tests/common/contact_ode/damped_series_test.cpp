// The damped oscillation's series against its closed forms in long double.
#include "common/impact/ode/damped_series.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <CppUTest/TestHarness.h>

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
