// Readout against truth: is a number farther from it than its stated uncertainty allows, and does a flag say
// so? Pure; thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "common/reduction/readout.hpp"

namespace strobe::soak {

/// How many standard deviations a number may be off, so that by chance alone `false_alarms` of `comparisons`
/// normal errors are farther off.
double sigma_limit(double comparisons, double false_alarms);

/// 16 numbers a shot, a million shots, one false alarm in a thousand such runs: 6.6 sd.
double soak_sigma_limit();

/// Whether the flag says that numbers may be wrong beyond their stated uncertainty:
///  - flags of a shot that does not count and is fired again do, and sensor_missing, since a flash's time is
///    then that of one lamp, or of none;
///  - spin_aliased does: every number of the shot;
///  - the other flags (an image left out, few images, sds from residuals) excuse no wrong number.
bool explains(reduction::Flag flag);

struct TruthComparison {
  int compared = 0;
  double largest_z = 0.0;                             ///< of the numbers that no flag explains
  std::array<double, reduction::kQuantityCount> z{};  ///< 0: not compared
  /// Numbers beyond the limit.
  int explained = 0;
  int mismatched = 0;  ///< dwell times and distances where the images do not tell, see Truth
  std::array<bool, reduction::kFlagCount> by_flag{};  ///< that explained one of them
  std::string wrong;                                  ///< the others, in words; empty: none
};

/// What is true of a shot.
struct Truth {
  reduction::Quantities value;
  /// The photograph lacks an image of a flash that was seen, or has one too many, or a flash's time or sensor
  /// was disturbed. Next to the contact the host then takes one match for another once in a while, as its
  /// stated odds say (host/assembly/flash_match.hpp): the dwell time is off by a period. Such numbers are
  /// counted apart.
  bool images_do_not_tell = false;
};

/// truth: absent numbers are those that the shot does not have: of a shot without a ball, all. A number that
/// is stated and not there in truth is wrong unless explained.
TruthComparison judge(const reduction::Readout& readout, const Truth& truth, double limit);

}  // namespace strobe::soak
