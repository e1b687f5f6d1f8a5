#include "host/series/sample_size.hpp"

#include <algorithm>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::host {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double square(double x) { return x * x; }

/// The fewest n >= 2 for which `is_enough` holds, which does so for every larger one; kMaxShots if none below
/// it does.
template <typename IsEnough>
int fewest_shots(const IsEnough& is_enough) {
  if (is_enough(2)) return 2;
  int few = 2, many = kMaxShots;
  while (many - few > 1) {
    const int middle = few + (many - few) / 2;
    (is_enough(middle) ? many : few) = middle;
  }
  return many;
}

/// An sd over its estimate: the ends of its 95 % interval.
struct SdFactors {
  double low = 1.0, high = 1.0;
};

SdFactors sd_factors(double degrees_of_freedom) {
  if (degrees_of_freedom > statistics::kAsGoodAsNormal) return {};
  const auto factor = [&](double below) {
    return std::sqrt(degrees_of_freedom / statistics::chi_squared_quantile(degrees_of_freedom, below));
  };
  return {factor(0.975), factor(0.025)};
}

/// Of n shots' scatter, over the true one: what `below` of series have less than.
double scatter_ratio(int n, double below) {
  return std::sqrt(statistics::chi_squared_quantile(n - 1.0, below) / (n - 1.0));
}

int count_for_mean(double scatter_sd, double shared_sd, double half_width, std::optional<double> assurance) {
  return fewest_shots(
      [&](int n) { return expected_half_width(scatter_sd, shared_sd, n, assurance) <= half_width; });
}

/// Of both scatters as they are together in a difference of equally many shots.
double joint_freedom(const TwoSeries& series) {
  const double a = square(series.first.sd), b = square(series.second.sd);
  const double uncertain = a * a / series.first.degrees_of_freedom + b * b / series.second.degrees_of_freedom;
  return uncertain > 0.0 ? square(a + b) / uncertain : kNever;
}

int count_for_difference(const TwoSeries& series, double sd_factor, double difference, double power) {
  const TwoMeans means{square(sd_factor * series.first.sd), square(sd_factor * series.second.sd),
                       square(series.shared_sd)};
  return fewest_shots([&](int n) {
    return means.power(difference, std::max(n, series.fired_first), std::max(n, series.fired_second)) >=
           power;
  });
}

}  // namespace

double mean_half_width(double scatter_sd, double shared_sd, int n) {
  const double own = square(scatter_sd) / n, variance = own + square(shared_sd);
  const double freedom = own > 0.0 ? (n - 1) * square(variance / own) : kNever;
  return std::sqrt(variance) * statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
}

double expected_half_width(double scatter_sd, double shared_sd, int n, std::optional<double> assurance) {
  const auto where_below = [&](double below) {
    return mean_half_width(scatter_sd * scatter_ratio(n, below), shared_sd, n);
  };
  if (assurance) return where_below(*assurance);
  // Over the scatter's probability: within 0.3 % of the mean for two shots, 0.01 % for ten.
  return boost::math::quadrature::gauss<double, 10>::integrate(where_below, 0.0, 1.0);
}

std::optional<ShotCount> shots_for_mean(const Scatter& scatter, double shared_sd, double half_width,
                                        std::optional<double> assurance) {
  if (!(mean_half_width(0.0, shared_sd, 2) < half_width)) return std::nullopt;
  const SdFactors factors = sd_factors(scatter.degrees_of_freedom);
  const auto count = [&](double factor) {
    return count_for_mean(factor * scatter.sd, shared_sd, half_width, assurance);
  };
  return ShotCount{count(1.0), count(factors.low), count(factors.high)};
}

double TwoMeans::degrees_of_freedom(double n1, double n2) const {
  const double a = first_variance / n1, b = second_variance / n2;
  const double uncertain = a * a / (n1 - 1.0) + b * b / (n2 - 1.0);
  const double all = a + b + shared_variance;
  return uncertain > 0.0 ? all * all / uncertain : kNever;
}

double TwoMeans::power(double difference, double n1, double n2) const {
  const double variance = total_variance(n1, n2);
  if (!(variance > 0.0)) return 1.0;
  const double freedom = degrees_of_freedom(n1, n2), shift = difference / std::sqrt(variance);
  const double t = statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
  return statistics::noncentral_t_tail(t, freedom, shift) + statistics::noncentral_t_tail(t, freedom, -shift);
}

std::optional<ShotCount> shots_for_difference(const TwoSeries& series, double difference, double power) {
  const TwoMeans endless{0.0, 0.0, square(series.shared_sd)};
  if (!(difference > 0.0) || endless.power(difference, kNever, kNever) < power) return std::nullopt;
  const SdFactors factors = sd_factors(joint_freedom(series));
  const auto count = [&](double factor) { return count_for_difference(series, factor, difference, power); };
  return ShotCount{count(1.0), count(factors.low), count(factors.high)};
}

}  // namespace strobe::host
