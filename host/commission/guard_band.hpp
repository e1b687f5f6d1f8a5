// One number against its limits, by guard bands on both sides of each (JCGM 106:2012, 8.3), the same for all
// steps: with standard uncertainty u and k = 2 it passes where value ± k u lies within the limits, fails
// where it lies beyond one of them, and is not told apart else. Of rigs whose true value is just at a
// limit 2.3 % pass and 2.3 % fail (one side of a normal). Pure; thread-safe; hold() allocates.
#pragma once

#include <limits>
#include <string>

#include "host/commission/record/step_result.hpp"

namespace strobe::commission {

inline constexpr double kGuard_sd = 2.0;  ///< k
/// Of a normal within ± k.
inline constexpr double kGuardProbability = 0.9545;

/// Where the true value is, with kGuardProbability.
struct Interval {
  double least = 0.0, most = 0.0;
};
constexpr Interval interval(double value, double sd) {
  return {value - kGuard_sd * sd, value + kGuard_sd * sd};
}

struct Limits {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
};
constexpr Limits within(double tolerance, double about = 0.0) {
  return {about - tolerance, about + tolerance};
}

/// What makes most numbers more certain.
inline constexpr const char* kMoreShots = "take more shots (--times 4)";

/// Holds one of a result's numbers against its limits. The first that fails counts, else the first that is
/// not told. `mend`: what to do where it failed; `tell`: what would tell.
void hold(StepResult& result, const Interval& found, const Limits& limits, const char* fault,
          const std::string& mend, const std::string& tell = kMoreShots);

}  // namespace strobe::commission
