#include "host/digitize/surface/step_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::digitize;

constexpr double kNoSaturation = 1e9;

/// 21 pixels of a step of `height` at `at` above a background of .1, by 200 points over each pixel.
std::vector<double> samples(double at, double height, double sd_px) {
  std::vector<double> intensity;
  for (int k = 0; k < 21; ++k) {
    double sum = 0.0;
    for (int i = 0; i < 200; ++i)
      sum += 0.5 * std::erfc(-(k - 0.5 + (i + 0.5) / 200.0 - at) / (sd_px * std::numbers::sqrt2));
    intensity.push_back(0.1 + height * sum / 200.0);
  }
  return intensity;
}

}  // namespace

TEST_GROUP(StepFit){};

TEST(StepFit, FindsTheEdgeBetweenPixels) {
  for (double at = 9.0; at < 11.0; at += 0.13) {
    const auto fit = fit_step(samples(at, 0.5, 0.9), kNoSaturation, 10.0, {Blur::normal, 0.9});
    CHECK_TRUE(fit.has_value());
    // It ends below steps of 1e-3 px, where a quadratically converging fit is off by 1e-6; the points' sum errs by
    // as much.
    DOUBLES_EQUAL(at, fit->at, 1e-4);
    DOUBLES_EQUAL(0.5, fit->step, 1e-3);
  }
}

TEST(StepFit, NeedsNoLightAboveSaturation) {
  for (const double saturation : {0.4, 0.9}) {
    std::vector<double> intensity = samples(10.3, 1.7, 0.9);
    for (double& light : intensity) light = std::min(light, saturation);
    const auto fit = fit_step(intensity, saturation, 9.6, {Blur::normal, 0.9});
    CHECK_TRUE(fit.has_value());
    DOUBLES_EQUAL(10.3, fit->at, 1e-2);
    // Cut off as if it were the whole step, the edge lies at half of what is left.
    const auto cut_off = fit_step(intensity, kNoSaturation, 9.6, {Blur::normal, 0.9});
    CHECK_TRUE(!cut_off || cut_off->at < 10.1);
  }
}

TEST(StepFit, SaysHowMuchNoiseMovesTheEdge) {
  // By the derivative: one sample by a small amount at a time.
  const std::vector<double> exact = samples(10.2, 0.5, 0.9);
  const StepShape shape{Blur::normal, 0.9};
  double squares = 0.0;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    std::vector<double> moved = exact;
    moved[k] += 1e-3;
    squares += std::pow((fit_step(moved, kNoSaturation, 10.0, shape)->at - 10.2) / 1e-3, 2);
  }
  // The fit ends within 1e-6 px, 1e-3 of these shifts.
  DOUBLES_EQUAL(1.0, std::sqrt(squares / fit_step(exact, kNoSaturation, 10.0, shape)->variance), 0.02);
}

TEST(StepFit, OfEvenLightOrOfAFallIsNone) {
  const std::vector<double> even(21, 0.3);
  CHECK_FALSE(fit_step(even, kNoSaturation, 10.0, {Blur::normal, 1.0}).has_value());
  std::vector<double> fall = samples(10.0, 0.5, 0.9);
  std::ranges::reverse(fall);
  CHECK_FALSE(fit_step(fall, kNoSaturation, 10.0, {Blur::normal, 0.9}).has_value());
  CHECK_FALSE(fit_step(std::vector<double>(4, 0.3), kNoSaturation, 2.0, {Blur::normal, 1.0}).has_value());
}
