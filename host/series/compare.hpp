// The difference of two series, quantity by quantity, and how many shots would decide. What both share, as a
// calibration, moves both alike and cancels as far as it does. Deterministic; thread-safe; allocates. Source:
// B. L. Welch, The generalization of Student's problem, Biometrika 34 (1947); GUM 5.2 and G.4.
#pragma once

#include <array>
#include <optional>

#include "host/series/sample_size.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

struct QuantityDifference {
  double difference = 0.0;                   ///< mean of the first less that of the second
  double standard_error = 0.0;               ///< of both series' scatter
  double shared_sd = 0.0;                    ///< what of the shared sources does not cancel
  double total_sd = 0.0;                     ///< both
  std::optional<double> degrees_of_freedom;  ///< effective; absent: infinitely many
  double expanded_uncertainty = 0.0;         ///< half width of the 95 % interval
  bool decided = false;                      ///< the interval does not hold 0
  double p_value = 1.0;                      ///< probability of as large a difference if there were none
  /// Shots of each series by which a difference of `asked` is found with the probability `power`, and further
  /// ones that each needs until then; 0: it has enough; absent: no number of shots would do, since what they
  /// share is too uncertain.
  std::optional<ShotCount> of_each;
  std::optional<int> more_first, more_second;
  double power = kPower;
  double asked = 0.0;     ///< > 0; 0: none was asked for, and none found
  bool is_asked = false;  ///< by the caller
};

struct Comparison {
  std::array<std::optional<QuantityDifference>, reduction::kQuantityCount> quantities{};  ///< index: Quantity

  const std::optional<QuantityDifference>& of(reduction::Quantity q) const {
    return quantities[static_cast<std::size_t>(q)];
  }
};

/// Of the quantities of which both series have two shots, all with their budgets. `asked`: the sizes that
/// shots are counted for, each in its quantity's unit, > 0; absent: that which was found. power: kMinPower to
/// kMaxPower.
Comparison compare(const Series& first, const Series& second, const reduction::Quantities& asked = {},
                   double power = kPower);

}  // namespace strobe::host
