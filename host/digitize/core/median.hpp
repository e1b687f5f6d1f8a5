// Medians of a few numbers. Of none: 0. Thread-safe.
#pragma once

#include <vector>

namespace strobe::digitize {

/// Of an even number the mean of the middle two.
double median(std::vector<double> values);

/// Of an even number the larger of the middle two.
double upper_median(std::vector<double> values);

}  // namespace strobe::digitize
