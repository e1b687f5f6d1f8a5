// Sums that an Error is made of. Plain values.
#pragma once

#include <cmath>

#include "tests/studies/trade/study.hpp"

namespace strobe::studies::trade {

class Tally {
 public:
  void add(double error) {
    square_ += error * error;
    // Keeps a NaN, so that it is seen.
    worst_ = std::isnan(error) || error > worst_ ? error : worst_;
    ++count_;
  }
  Error error() const { return {count_ > 0 ? std::sqrt(square_ / count_) : 0.0, worst_}; }

 private:
  double square_ = 0.0, worst_ = 0.0;
  int count_ = 0;
};

}  // namespace strobe::studies::trade
