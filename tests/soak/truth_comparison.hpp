// Compares a readout with the truth: whether an error is larger than its stated uncertainty allows, and
// whether a flag says so. Pure; thread-safe.
#pragma once

#include <array>
#include <string>

#include "common/reduction/readout.hpp"

namespace strobe::soak {

/// The limit in standard deviations that by chance `false_alarms` of `comparisons` normal errors exceed.
double sigma_limit(double comparisons, double false_alarms);

/// 16 numbers a shot, a million shots, one false alarm in a thousand such runs: 6.6 sd.
double soak_sigma_limit();

/// Whether the flag says that numbers may be wrong beyond their stated uncertainty:
///  - flags of a shot that does not count and is fired again do, and sensor_missing, since a flash's time is
///    then that of one lamp, or of none;
///  - spin_aliased, surface_suspect, scale_contradicts_ball and residuals_exceed_noise do: every number of the shot;
///  - the other flags (an image or a surface point left out, few images, sds from residuals) excuse no wrong number.
bool explains(reduction::Flag flag);

struct TruthComparison {
  int compared = 0;
  double largest_z = 0.0;                             ///< of the numbers that no flag explains
  std::array<double, reduction::kQuantityCount> z{};  ///< 0: not compared
  /// Numbers beyond the limit.
  int explained = 0;
  int mismatched = 0;  ///< dwell times and distances where the images are ambiguous, see Truth
  std::array<bool, reduction::kFlagCount> by_flag{};  ///< explained at least one of them
  std::string wrong;                                  ///< the others, as text; empty if none
};

/// True values of a shot.
struct Truth {
  reduction::Quantities value;
  /// The photograph lacks an image of a flash that was seen, or has one too many, or a flash's time or sensor
  /// was disturbed. Next to the contact the host then takes one match for another once in a while, as its
  /// stated odds say (common/reduction/matching/flash_match.hpp): the dwell time is off by a period. Such numbers are
  /// counted apart.
  bool images_ambiguous = false;
};

/// A number that the truth lacks (all of them without a ball) is wrong if stated, unless a flag explains it.
TruthComparison compare_with_truth(const reduction::Readout& readout, const Truth& truth, double limit);

}  // namespace strobe::soak
