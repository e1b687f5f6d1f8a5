// Limits of a run chart of single shots: an individuals chart. Pure; thread-safe.
// Source: W. A. Shewhart, Economic Control of Quality of Manufactured Product (1931); ISO 7870-2:2013, individuals and
// moving range.
#pragma once

#include <optional>
#include <span>

namespace strobe::host {

/// Mean and three standard deviations either way, the sd from the mean range of two shots that follow each other, so that
/// a drift does not widen them.
struct IndividualsLimits {
  double mean = 0.0, lower = 0.0, upper = 0.0;
};

/// Mean range of two normal numbers over their standard deviation, 2/sqrt(pi).
inline constexpr double kRangeOfTwo = 1.1283791670955126;
/// Below, one range or two say next to nothing of the scatter.
inline constexpr std::size_t kMinForLimits = 4;

/// values: of the shots that count, in the order of firing. Absent below kMinForLimits.
std::optional<IndividualsLimits> individuals_limits(std::span<const double> values);

}  // namespace strobe::host
