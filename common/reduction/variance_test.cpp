#include "common/reduction/variance_test.hpp"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>

namespace strobe::reduction {
namespace {

using DoublePolicy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

constexpr double kAsGoodAsKnown = 1e6;

}  // namespace

double chance_of_scatter(double sum_of_squares, double degrees_of_freedom, double noise_freedom) {
  if (!(degrees_of_freedom > 0.0) || !(sum_of_squares > 0.0)) return 1.0;
  if (!std::isfinite(sum_of_squares)) return 0.0;
  if (noise_freedom > kAsGoodAsKnown)
    return boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * sum_of_squares, DoublePolicy());
  if (!(noise_freedom > 0.0)) return 1.0;
  const boost::math::fisher_f_distribution<double, DoublePolicy> f(degrees_of_freedom, noise_freedom);
  return boost::math::cdf(boost::math::complement(f, sum_of_squares / degrees_of_freedom));
}

}  // namespace strobe::reduction
