#include "common/impact/fit/quantiles.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace strobe::impact {

namespace {

using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;

}  // namespace

double students_t_quantile(double degrees_of_freedom, double above) {
  const boost::math::students_t_distribution<double, Policy> distribution(degrees_of_freedom);
  return boost::math::quantile(boost::math::complement(distribution, above));
}

double chi_squared_quantile(double degrees_of_freedom, double below) {
  const boost::math::chi_squared_distribution<double, Policy> distribution(degrees_of_freedom);
  return boost::math::quantile(distribution, below);
}

double f_tail(double ratio, double upper_degrees, double lower_degrees) {
  const boost::math::fisher_f_distribution<double, Policy> distribution(upper_degrees, lower_degrees);
  return boost::math::cdf(boost::math::complement(distribution, ratio));
}

}  // namespace strobe::impact
