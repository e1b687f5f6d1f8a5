// Numbers as hostile as an input may be: zeros, subnormal, huge, infinite, not a number, and ordinary ones
// often enough that most calls get past the first check. Generators of rapidcheck.
#pragma once

#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <vector>

namespace strobe::numerics {

/// Values at which arithmetic changes: of either sign.
inline const std::vector<double>& extremes() {
  static const std::vector<double> all = [] {
    using Limits = std::numeric_limits<double>;
    std::vector<double> values{0.0,
                               Limits::denorm_min(),
                               1e-310,
                               Limits::min(),
                               1e-200,
                               1e-155,
                               1e-60,
                               1e-31,
                               1e-30,
                               1e-15,
                               1.0,
                               1e15,
                               1e30,
                               1.1e30,
                               1e60,
                               1e154,
                               1e155,
                               1e200,
                               1e307,
                               Limits::max(),
                               Limits::infinity(),
                               Limits::quiet_NaN()};
    const std::size_t count = values.size();
    for (std::size_t i = 0; i < count; ++i) values.push_back(-values[i]);
    return values;
  }();
  return all;
}

/// An ordinary value of low…high, both ends included.
inline double ordinary(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

/// One time in `rarity` an extreme, else an ordinary value. A failure prints what was drawn, in order.
inline double hostile(double low, double high, int rarity = 8) {
  double value = ordinary(low, high);
  if (*rc::gen::inRange(0, rarity) == 0) {
    const auto& all = extremes();
    value = all[*rc::gen::inRange<std::size_t>(0, all.size())];
  }
  RC_LOG() << value << ' ';
  return value;
}

template <typename... T>
bool finite(T... values) {
  return (std::isfinite(values) && ...);
}

}  // namespace strobe::numerics
