#include "common/reduction/expanded_uncertainty.hpp"

#include <cmath>
#include <limits>

#include "common/reduction/student_t.hpp"

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
  const double noise = *sd * student_t_half_width(kExpandedLevel, freedom) / student_t_sigma(freedom);
  const double tolerances =
      readout.sd_systematic[quantity].value_or(0.0) * student_t_half_width(kExpandedLevel, kInfinite);
  return std::hypot(noise, tolerances);
}

}  // namespace strobe::reduction
