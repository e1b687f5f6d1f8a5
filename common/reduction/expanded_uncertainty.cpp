#include "common/reduction/expanded_uncertainty.hpp"

#include <cmath>
#include <limits>

#include "common/statistics/distributions.hpp"

namespace strobe::reduction {

std::optional<double> total_sd(const Readout& readout, Quantity quantity) {
  const auto& sd = readout.sd[quantity];
  if (!sd) return std::nullopt;
  return std::hypot(*sd, readout.sd_systematic[quantity].value_or(0.0));
}

std::optional<double> expanded_uncertainty(const Readout& readout, Quantity quantity) {
  const auto& sd = readout.sd[quantity];
  if (!sd) return std::nullopt;
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const double freedom = readout.degrees_of_freedom[quantity].value_or(kInfinite);
  const double noise =
      *sd * statistics::student_t_half_width(kExpandedLevel, freedom) / statistics::student_t_sigma(freedom);
  const double tolerances = readout.sd_systematic[quantity].value_or(0.0) *
                            statistics::student_t_half_width(kExpandedLevel, kInfinite);
  return std::hypot(noise, tolerances);
}

}  // namespace strobe::reduction
