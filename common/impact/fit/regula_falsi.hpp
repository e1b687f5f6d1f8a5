// A bracketed root by regula falsi with the Illinois rule (M. Dowell and P. Jarratt, BIT 11, 1971), for functions that
// are costly and about straight. Deterministic; thread-safe.
#pragma once

#include <cassert>
#include <cmath>

namespace strobe::impact {

struct FunctionValue {
  double at = 0.0;
  double value = 0.0;
};

/// The end of the last bracket on the side of `second`, whose value has the other sign than that of `first` or is 0.
/// Done when the ends are within `tolerance`, or the value is 0.
template <typename Function>
FunctionValue regula_falsi(Function function, FunctionValue first, FunctionValue second, double tolerance) {
  assert((first.value > 0.0) != (second.value > 0.0) || second.value == 0.0);
  constexpr int kMaxSteps = 100;
  double first_weight = first.value, second_weight = second.value;
  int last = 0;
  for (int i = 0; i < kMaxSteps && std::abs(second.at - first.at) > tolerance && second.value != 0.0; ++i) {
    const double at = first.at + (second.at - first.at) * first_weight / (first_weight - second_weight);
    const FunctionValue now{at, function(at)};
    if ((now.value > 0.0) == (first.value > 0.0) && now.value != 0.0) {
      first = now;
      first_weight = now.value;
      if (last == 1) second_weight *= 0.5;
      last = 1;
    } else {
      second = now;
      second_weight = now.value;
      if (last == 2) first_weight *= 0.5;
      last = 2;
    }
  }
  return second;
}

}  // namespace strobe::impact
