#include "host/digitize/outline/edge_profile.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using strobe::digitize::blurred_sqrt;
using strobe::digitize::blurred_step;

TEST_GROUP(EdgeProfile){};

TEST(EdgeProfile, OfAStepIsHalfAtTheOutline) {
  // Linear interpolation between cells of 1/64 errs by at most (1/64)²/8 of the second derivative, 0.25.
  DOUBLES_EQUAL(0.5, blurred_step(0.0, 1.7).value, 1e-5);
  DOUBLES_EQUAL(0.841344746, blurred_step(1.7, 1.7).value, 1e-5);
  DOUBLES_EQUAL(1.0, blurred_step(40.0, 1.7).value, 1e-9);
}

TEST(EdgeProfile, OfARootIsTheGammaFunctionsAtTheOutlineAndTheRootFarInside) {
  // ∫ sqrt(t) exp(-t²/2) dt / sqrt(2 pi) = 2^(-1/4) Gamma(3/4) / sqrt(2 pi)
  const double at_zero = std::pow(2.0, -0.25) * std::tgamma(0.75) / std::sqrt(2.0 * std::acos(-1.0));
  DOUBLES_EQUAL(at_zero, blurred_sqrt(0.0, 1.0).value, 1e-4);
  DOUBLES_EQUAL(2.0 * at_zero, blurred_sqrt(0.0, 4.0).value, 2e-4);
  DOUBLES_EQUAL(5.0, blurred_sqrt(25.0, 0.5).value, 1e-3);
}

TEST(EdgeProfile, ChangesAsItsDerivativesSay) {
  constexpr double kSmall = 0.25;
  for (const double depth : {-2.0, -0.5, 0.3, 1.0, 4.0, 30.0}) {
    for (const auto profile : {blurred_step, blurred_sqrt}) {
      const double sigma = 1.3;
      const auto here = profile(depth, sigma);
      // Central differences; third derivatives are below 0.6 here, which leaves 0.6·kSmall²/6.
      DOUBLES_EQUAL(
          (profile(depth + kSmall, sigma).value - profile(depth - kSmall, sigma).value) / (2 * kSmall),
          here.by_depth, 0.007);
      DOUBLES_EQUAL(
          (profile(depth, sigma + kSmall).value - profile(depth, sigma - kSmall).value) / (2 * kSmall),
          here.by_sigma, 0.02);
    }
  }
}
