#include "common/reduction/variance_test.hpp"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace strobe::reduction {
namespace {

using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

constexpr double kAsGoodAsKnown = 1e6;

}  // namespace

double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom) {
  if (!(degrees_of_freedom > 0.0) || !(sum_of_squares > 0.0)) return 1.0;
  if (!std::isfinite(sum_of_squares)) return 0.0;
  if (noise_freedom > kAsGoodAsKnown)
    return boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * sum_of_squares, Policy());
  if (!(noise_freedom > 0.0)) return 1.0;
  const boost::math::fisher_f_distribution<double, Policy> f(degrees_of_freedom, noise_freedom);
  return boost::math::cdf(boost::math::complement(f, sum_of_squares / degrees_of_freedom));
}

double normal_square_exceeded(double probability) {
  const double sds = std::sqrt(2.0) * boost::math::erfc_inv(probability, Policy());
  return sds * sds;
}

}  // namespace strobe::reduction
