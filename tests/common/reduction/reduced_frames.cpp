#include "tests/common/reduction/reduced_frames.hpp"

#include <numbers>

#include "common/reduction/reduce.hpp"
#include "tests/support/error_of.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::test {

using namespace reduction;

BallImage ball_image(double time_ms, Leg leg, double x, double y, double equator) {
  BallImage out;
  out.time_s = time_ms * 1e-3;
  out.leg = leg;
  out.centre_px = {x, y};
  out.diameter_px = 65.0;
  out.equator_rad = equator;
  return out;
}

Frame straight_frame() {
  Frame frame;
  frame.shot_id = 7;
  frame.ball_diameter_m = 0.065;
  frame.fastest_spin_radps = 630.0;
  frame.surface_px = {{0, 100}, {100, 100}, {200, 100}, {300, 100}};
  frame.centre_sd_px = 0.5;
  frame.diameter_sd_px = 0.5;
  frame.equator_sd_rad = 0.01;
  frame.images = {ball_image(0, Leg::incoming, 90, 156.5, 0.1),
                  ball_image(2, Leg::incoming, 120, 144.5, std::numbers::pi - 0.1),
                  ball_image(6, Leg::contact, 170, 120, 0.0), ball_image(10, Leg::rebound, 209, 137.5, 1.5),
                  ball_image(12, Leg::rebound, 227, 147.5, 1.8)};
  return frame;
}

Readout reduced(const Frame& frame, Estimator estimator) {
  Frame in_vacuum = frame;
  in_vacuum.air_density_kgpm3 = 0.0;
  const auto readout = reduce(in_vacuum, estimator);
  if (!readout) FAIL(readout.error().message.c_str());
  return *readout;
}

Readout reduced_in_air(const Frame& frame) {
  const auto readout = reduce(frame, Estimator::best, {.likely_cause = true});
  if (!readout) FAIL(readout.error().message.c_str());
  return *readout;
}

std::string complaint(const Frame& frame) { return testing::error_of(reduce(frame, Estimator::best)); }

void equal(double expected, const std::optional<double>& actual, double tolerance) {
  CHECK_TRUE(actual.has_value());
  DOUBLES_EQUAL(expected, *actual, tolerance);
}

Setup vacuum() {
  Setup setup;
  setup.air = {.drag_coefficient = 0.0, .lift = false, .spin_decay_per_m = 0.0};
  return setup;
}

Frame noisy(const Setup& setup, std::uint64_t seed) {
  Random random(seed);
  return photograph(Bounce{}, setup, random);
}

}  // namespace strobe::test
