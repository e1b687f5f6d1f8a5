#include "common/statistics/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/non_central_t.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace strobe::statistics {
namespace {

// Promoted to long double, quantiles would fail at the start of a program under valgrind, which has none.
using Policy = boost::math::policies::policy<boost::math::policies::promote_double<false>>;
using StudentsT = boost::math::students_t_distribution<double, Policy>;
using ChiSquared = boost::math::chi_squared_distribution<double, Policy>;
using FisherF = boost::math::fisher_f_distribution<double, Policy>;
using NoncentralT = boost::math::non_central_t_distribution<double, Policy>;
using Normal = boost::math::normal_distribution<double, Policy>;

}  // namespace

double student_t_quantile(double degrees_of_freedom, double above) {
  if (degrees_of_freedom > kAsGoodAsNormal)
    return boost::math::quantile(boost::math::complement(Normal(), above));
  return boost::math::quantile(boost::math::complement(StudentsT(degrees_of_freedom), above));
}

double student_t_sigma(double degrees_of_freedom) {
  return degrees_of_freedom > kAsGoodAsNormal ? 1.0 : student_t_quantile(degrees_of_freedom, kAboveOneSd);
}

double student_t_half_width(double share, double degrees_of_freedom) {
  return student_t_quantile(degrees_of_freedom, 0.5 * (1.0 - share));
}

double student_t_tail(double t, double degrees_of_freedom) {
  if (degrees_of_freedom > kAsGoodAsNormal) return std::erfc(std::abs(t) / std::sqrt(2.0));
  return 2.0 * boost::math::cdf(boost::math::complement(StudentsT(degrees_of_freedom), std::abs(t)));
}

double noncentral_t_tail(double t, double degrees_of_freedom, double shift) {
  // Beyond these shifts the normal number hardly counts, and the library's series becomes long.
  constexpr double kMin = -8.0, kMax = 50.0;
  if (degrees_of_freedom > kAsGoodAsNormal) return 0.5 * std::erfc((t - shift) / std::sqrt(2.0));
  if (shift < kMin) return 0.0;
  if (shift > kMax)
    return 1.0 - chi_squared_tail(degrees_of_freedom * (shift / t) * (shift / t), degrees_of_freedom);
  return boost::math::cdf(boost::math::complement(NoncentralT(degrees_of_freedom, shift), t));
}

double chi_squared_quantile(double degrees_of_freedom, double below) {
  return boost::math::quantile(ChiSquared(degrees_of_freedom), below);
}

double chi_squared_tail(double sum_of_squares, double degrees_of_freedom) {
  return boost::math::gamma_q(0.5 * degrees_of_freedom, 0.5 * sum_of_squares, Policy());
}

double f_tail(double ratio, double upper_degrees, double lower_degrees) {
  return boost::math::cdf(boost::math::complement(FisherF(upper_degrees, lower_degrees), ratio));
}

}  // namespace strobe::statistics
