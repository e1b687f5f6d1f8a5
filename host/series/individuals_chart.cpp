#include "host/series/individuals_chart.hpp"

#include <cmath>

namespace strobe::host {

std::optional<IndividualsLimits> individuals_limits(std::span<const double> values) {
  if (values.size() < kMinForLimits) return std::nullopt;
  double sum = 0.0, ranges = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    if (i > 0) ranges += std::abs(values[i] - values[i - 1]);
  }
  const double mean = sum / static_cast<double>(values.size());
  const double sd = ranges / static_cast<double>(values.size() - 1) / kRangeOfTwo;
  return IndividualsLimits{mean, mean - 3.0 * sd, mean + 3.0 * sd};
}

}  // namespace strobe::host
