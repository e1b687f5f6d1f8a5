#include "common/reduction/student_t.hpp"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace strobe::reduction {
namespace {

// erf(1/sqrt 2) is the share within one sd; half of the rest lies above it.
constexpr double kAboveOneSd = 0.158655253931457;
constexpr double kAsGoodAsNormal = 1e6;

// Promoted to long double, quantiles would fail at the start of a program under valgrind, which has none.
using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
using StudentsT = boost::math::students_t_distribution<double, Policy>;
using NormalDistribution = boost::math::normal_distribution<double, Policy>;

}  // namespace

double student_t_sigma(double degrees_of_freedom) {
  if (degrees_of_freedom > kAsGoodAsNormal) return 1.0;
  const StudentsT distribution(degrees_of_freedom);
  return boost::math::quantile(boost::math::complement(distribution, kAboveOneSd));
}

double student_t_half_width(double share, double degrees_of_freedom) {
  const double above = 0.5 * (1.0 - share);
  if (degrees_of_freedom > kAsGoodAsNormal)
    return boost::math::quantile(boost::math::complement(NormalDistribution(), above));
  return boost::math::quantile(boost::math::complement(StudentsT(degrees_of_freedom), above));
}

double student_t_tail(double t, double degrees_of_freedom) {
  if (degrees_of_freedom > kAsGoodAsNormal) return std::erfc(std::abs(t) / std::sqrt(2.0));
  const StudentsT distribution(degrees_of_freedom);
  return 2.0 * boost::math::cdf(boost::math::complement(distribution, std::abs(t)));
}

}  // namespace strobe::reduction
