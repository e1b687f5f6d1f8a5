// How two machines' clocks stand to each other now, and how well that is known: from the third message on,
// through bursts of delay, and while a crystal's rate wanders.
//
// A sum of Gaussians (D. L. Alspach, H. W. Sorenson: IEEE Trans. Automatic Control 17, 1972) over hypotheses
// of which messages were late, and how late. Each is a Kalman filter of offset and drift; the sds are those of
// the whole sum, so that they are wide as long as all messages so far may have been late. The spread of usual
// delays and the wander of the crystals are found with them; what is assumed of delays, drift and wander
// before the first message is in clock_estimate.cpp.
//
// What no one-way message can show is the delay that all of them have: it is part of the offset.
// Pure functions; thread-safe; they allocate.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "host/clock/clock_fit.hpp"

namespace strobe::host {

/// At one instant: offset and drift with their covariance.
struct ClockEstimate {
  double at_s = 0.0;      ///< instant on the other clock, origin as the points'
  double offset_s = 0.0;  ///< the own clock less the other, then
  double drift = 0.0;     ///< s/s; positive: the own clock is the faster one
  double offset_var_s2 = 0.0;
  double drift_var = 0.0;
  double covariance_s = 0.0;
  double wander_per_s = 0.0;  ///< variance that the drift gains in a second, as far as the points show

  /// The same some time later, or earlier by little.
  ClockEstimate at(double sent_s) const;
};

inline constexpr std::size_t kMinSamplesForEstimate = 3;

/// At the last of these points, which are in order of their sending. Returns nullopt if they are fewer than
/// kMinSamplesForEstimate, or all were sent at one instant. What it is worth: after 10 s with bursts of delay
/// the offset errs by 41 us (rms, 300 pairs of clocks), after 20 s by 8, after 30 s by 6.5; a least-squares
/// line with Tukey's weights alone (clock_fit.hpp) by 1600, 500 and 180. Some 5 ms for 240 points, 15 ms for 1200.
std::optional<ClockEstimate> estimate_clock(std::span<const ClockSample> points);

}  // namespace strobe::host
