#include "common/reduction/variance_test.hpp"

#include <cmath>

#include "common/statistics/distributions.hpp"

namespace strobe::reduction {

double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom) {
  if (!(degrees_of_freedom > 0.0) || !(sum_of_squares > 0.0)) return 1.0;
  if (!std::isfinite(sum_of_squares)) return 0.0;
  if (noise_freedom > statistics::kAsGoodAsNormal)
    return statistics::chi_squared_tail(sum_of_squares, degrees_of_freedom);
  if (!(noise_freedom > 0.0)) return 1.0;
  return statistics::f_tail(sum_of_squares / degrees_of_freedom, degrees_of_freedom, noise_freedom);
}

}  // namespace strobe::reduction
