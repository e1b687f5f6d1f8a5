// Firing until a mean is known well enough: after each shot its interval is looked at, and the series ends as
// soon as it is short enough. Such looks favour series that scatter little by chance, so that the plain 95 %
// interval holds the truth in 92 % of cases only (Chow & Robbins, Ann. Math. Stat. 36, 1965; Starr, ibid. 37,
// 1966). Here no series ends before kMinSequentialShots, and the scatter counts sequential_inflation(n)-fold,
// both for the decision and in the interval that is given in the end. For normal scatter a mean is
// independent of how the scatter came about, so that the coverage can be computed to the digits (Robbins
// 1959; `strobe-bench series-coverage --how-many`): it is 95.1 to 95.3 %, whatever the wanted half width.
// Pure functions; thread-safe.
#pragma once

#include <optional>

#include "host/series/series.hpp"
#include "host/series/wanted.hpp"

namespace strobe::host {

inline constexpr int kMinSequentialShots = 5;

/// By how much more than Student's t of n - 1 degrees of freedom the scatter of n >= 1 shots counts; 1 below
/// kMinSequentialShots, where no series ends by the rule.
double sequential_inflation(int n);

/// Half width of the 95 % interval of the mean of n >= 2 shots, by the rule.
double sequential_half_width(double scatter_sd, double shared_sd, int n);

/// What a series by the rule says of what is wanted.
struct Known {
  enum class State {
    open,      ///< more shots are needed
    known,     ///< the interval is short enough
    no_value,  ///< none of kMinSequentialShots shots tells the quantity
    never      ///< what the shots share is alone as uncertain as that
  };
  State state = State::open;
  Wanted wanted;
  int n = 0;
  double wanted_half_width = 0.0;    ///< in the quantity's unit
  double shared_half_width = 0.0;    ///< 95 %, of what the shots share alone
  std::optional<double> half_width;  ///< absent below two shots
  /// Further shots, if the scatter stays what it is, up to kMaxShots; absent below two shots.
  std::optional<int> more;
};

/// summary: of a series that is fired by the rule, with budgets. A half width in percent is of the mean as it
/// is, whose own uncertainty is of the second order.
Known known_so_far(const SeriesSummary& summary, const Wanted& wanted);

}  // namespace strobe::host
