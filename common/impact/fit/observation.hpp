// The data of a rebound model's fit: the motion measured at touchdown and lift-off of a shot, or its means
// over the replicates of a condition, with standard deviations. Plain values; copying allocates (names).
// Thread-safe; not for the real-time path.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

/// Signs and units as in rebound.hpp. The standard deviations are of independent errors, >= 0.
struct Observation {
  std::string name;    ///< of this one, e.g. "zero_23" or "results.csv:7"; for messages and tables
  std::string spin;    ///< group of the leave-one-spin-out validation, e.g. "zero", "top", "back"
  std::string series;  ///< group of the leave-one-condition-out validation
  Motion touchdown;
  Motion touchdown_sd;
  Motion lift_off;
  Motion lift_off_sd;  ///< that of vy is not used, as e is given
  double e = 0.0;      ///< measured restitution, 0…1
  double e_sd = 0.0;
  double dwell_s = 0.0;  ///< touchdown to lift-off; 0: not measured
  double dwell_sd_s = 0.0;
  // The weight's parts towards the surface and along it, +x, in ode; 0: left out.
  double gravity_mps2 = 0.0;
  double gravity_along_mps2 = 0.0;
};

/// Keeps of observations whose motions and e are the same to the last digit the first: independent errors do
/// not repeat, so that they are one measurement. Of their sds it gets the largest. Returns a line for each
/// such one: its name and how many there were. Precondition: finite numbers.
std::vector<std::string> leave_copies_out(std::vector<Observation>& observations);

/// What standard deviations of a condition refer to.
enum class Spread {
  /// One replicate, as printed. "Within one sd" and the z-scores of the tables refer to these.
  replicate,
  /// The mean of n replicates: the printed population sd over sqrt(n - 1). It includes the machine's spread
  /// from shot to shot, which touchdown and lift-off share and which therefore cancels in part: an upper
  /// bound of the error of a comparison of means.
  mean,
};

/// A value in standard deviations; 0 for 0, infinite for any other value whose sd is 0.
double z_score(double value, double sd);

/// One observation for each condition, in the order given; e is the tables' own.
std::vector<Observation> observations_of(std::span<const thesis::Condition> conditions, Spread spread);

}  // namespace strobe::impact
