// The straight line between two machines' clocks, from messages that one sent and the other heard. A message
// may come late, also by much and many in a row, but never early: delays have one side.
//
// The start is the lower envelope of the points: the line below all of them that is nearest to them, which no
// delay can lift (S. B. Moon, P. Skelly, D. Towsley: Estimation and removal of clock skew from network delay
// measurements, INFOCOM 1999). From there iteratively reweighted least squares: above the line with J. W.
// Tukey's biweight, to which a message that is much too late is none, below it with P. J. Huber's weights
// (P. W. Holland, R. E. Welsch: Communications in Statistics A6, 1977).
//
// What no one-way message can show is the delay that all of them have: it is part of the offset.
// Pure functions; thread-safe; they allocate.
#pragma once

#include <optional>
#include <span>

namespace strobe::host {

/// A message: when it was sent on the other clock, and by how much the own clock was ahead of that when it
/// was heard; seconds, of any origin near the points.
struct ClockSample {
  double sent_s = 0.0;
  double offset_s = 0.0;
};

/// ahead = at_centre + drift * (sent - centre)
struct ClockLine {
  double centre_s = 0.0;
  double offset_at_centre_s = 0.0;
  double drift = 0.0;     ///< s/s; positive: the own clock is the faster one
  double spread_s = 0.0;  ///< sd of usual delays about the line
  int used = 0;           ///< points that have weight

  double offset_s(double sent_s) const { return offset_at_centre_s + drift * (sent_s - centre_s); }
};

inline constexpr std::size_t kMinSamplesForLine = 40;

/// Returns nullopt if they are fewer than kMinSamplesForLine, or all were sent at one instant. 240 points take
/// some 0.1 ms, which every instant can afford; clock_estimate.hpp, far better in the first minute, takes 5 ms.
std::optional<ClockLine> fit_clock(std::span<const ClockSample> points);

}  // namespace strobe::host
