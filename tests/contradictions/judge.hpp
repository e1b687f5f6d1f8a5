// Judges a readout by the truth: which of its numbers are wrong, and whether its flags say so.
// Pure functions of plain values; thread-safe.
#pragma once

#include <bitset>
#include <string_view>

#include "common/reduction/readout.hpp"
#include "tests/contradictions/photograph.hpp"
#include "tests/contradictions/trouble.hpp"

namespace strobe::contradictions {

/// A number is wrong if it is off by more than this many stated sd, statistical and systematic together, and by more
/// than its floor.
inline constexpr double kWrong_sd = 6.0;

/// A tenth of what digitizing by hand does to the number: below it no experiment notices.
double error_floor(reduction::Quantity quantity);

/// Names of flags that are facts and no alarms: on an undisturbed shot they are not false.
bool is_fact(std::string_view flag);

/// Whether `flag` tells that the quantity may be wrong in this kind of trouble. An aliased spin excuses spins and the slip
/// in every kind, and nothing else.
bool explains(std::string_view flag, reduction::Quantity quantity, Kind kind);

using Quantities = std::bitset<reduction::kQuantityCount>;

struct Judgement {
  Quantities silent;            ///< wrong, and no flag explains it
  Quantities flagged;           ///< wrong, and a flag explains it
  Quantities few;               ///< wrong, and nothing but no_redundancy explains it
  double worst = 0.0;           ///< largest error of a silently wrong number, in stated sd
  bool slides_wrongly = false;  ///< "slides" of a ball that gripped
  bool grips_wrongly =
      false;  ///< "grips" of a ball whose slip ended by less than it had to, by 6 sd and more
};

/// `few`: what is wrong is among few measurements (shot.hpp).
Judgement judged(const reduction::Readout& readout, const Truth& truth, Kind kind, bool few = false);

}  // namespace strobe::contradictions
