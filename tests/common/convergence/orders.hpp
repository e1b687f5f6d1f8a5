// How an error falls with the number of steps. Plain functions; thread-safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace strobe::testing {

struct Refinement {
  double steps = 0.0, error = 0.0;
};

/// Slope of log(error) over -log(steps) by least squares, over those refinements whose error is at least
/// `floor`: the order of the method on them. 0 with fewer than three.
inline double order_above(const std::vector<Refinement>& refinements, double floor) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const Refinement& r : refinements) {
    if (!(r.error >= floor)) continue;
    const double a = -std::log(r.steps), b = std::log(r.error);
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
  }
  return n < 3.0 ? 0.0 : (n * xy - x * y) / (n * xx - x * x);
}

inline double least_error(const std::vector<Refinement>& refinements) {
  return std::ranges::min_element(refinements, {}, &Refinement::error)->error;
}

}  // namespace strobe::testing
