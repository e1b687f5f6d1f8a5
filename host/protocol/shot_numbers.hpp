// A shot's quantities and inputs as numbers with their sources. Part of the evaluation, not of its interface.
// Not thread-safe per object; allocates.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/protocol/number.hpp"
#include "host/protocol/protocol.hpp"
#include "host/session/shot.hpp"

namespace strobe::protocol {

/// What slows a ball in air.
struct BallDrag {
  double drag_per_m = 0.0;
  Number error{};  ///< of the drag, as a share of it: value 0
};

/// Shots share errors as in host/series: calibration and ball tell whose they are. What the air does to a
/// ball is of its kind, and shared by all balls of it.
class ShotNumbers {
 public:
  explicit ShotNumbers(Sources& sources) : sources_(sources) {}

  /// Fails for a shot that lacks the number or its budget.
  Result<Number> quantity(const host::Shot& shot, reduction::Quantity q);
  /// As noted, else as the protocol fixes it. Fails if it is neither.
  Result<Number> input(const host::Shot& shot, const Input& input);
  Result<BallDrag> drag(const host::Shot& shot);

 private:
  const std::vector<std::array<double, reduction::kQuantityCount>>& own_effects(const host::Shot& shot);

  Sources& sources_;
  /// Independent ones, that add up to Budget::own_covariance.
  std::map<const host::Shot*, std::vector<std::array<double, reduction::kQuantityCount>>> own_;
};

}  // namespace strobe::protocol
