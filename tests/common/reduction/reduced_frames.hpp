// Frames to be reduced and what is asked of their readouts, for the tests of single numbers, checks and
// flags.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

namespace strobe::test {

/// Of 65 px.
reduction::BallImage ball_image(double time_ms, reduction::Leg leg, double x, double y, double equator);

/// 1000 px to the metre, ball of 65 mm, surface at y = 100, so touchdown and lift-off at y = 132.5.
/// In at (15, -6) m/s, that is 15 and 6 px a millisecond; touchdown at 4 ms, x = 150. Out at (9, 5) m/s;
/// lift-off at 9 ms, x = 200. Spin -100 before, written past the half turn (0.1 - 0.2 + pi), and 150 rad/s
/// after.
reduction::Frame straight_frame();

/// Without air.
Setup vacuum();
reduction::Frame noisy(const Setup& setup = vacuum(), std::uint64_t seed = 3);

/// In a vacuum: air is fitted first and left out where it does not matter, here always. The test fails if the
/// frame is refused.
reduction::Readout reduced(const reduction::Frame& frame,
                           reduction::Estimator estimator = reduction::Estimator::best);

/// Likewise in air of 20 degrees.
reduction::Readout reduced_in_air(const reduction::Frame& frame);

/// Why the frame is refused, or "accepted".
std::string complaint(const reduction::Frame& frame);

/// The test fails if there is no number, or one that is further off.
void equal(double expected, const std::optional<double>& actual, double tolerance = 1e-9);

}  // namespace strobe::test
