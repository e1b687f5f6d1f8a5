#include "tests/studies/series/how_many.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/quadrature/gauss.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "common/reduction/uncertainty.hpp"
#include "host/series/compare.hpp"
#include "host/series/sample_size.hpp"
#include "host/series/sequential.hpp"

namespace strobe::studies {
namespace {

double square(double x) { return x * x; }

/// How often |mean - truth| is at most h, of n shots with sd 1.
double held(double h, int n) { return std::erf(h * std::sqrt(0.5 * n)); }

using CriticalValue = std::function<double(int n)>;

/// The density of the sum of squares of series that go on, from where they end upwards, at equal steps.
class Continuing {
 public:
  Continuing(double from, double to) : from_(from), step_((to - from) / (kPoints - 1)) {}

  template <typename Density>
  void fill(const Density& density) {
    for (int i = 0; i < kPoints; ++i) values_[static_cast<std::size_t>(i)] = density(from_ + i * step_);
  }

  double from() const { return from_; }
  double to() const { return from_ + (kPoints - 1) * step_; }

  /// Cubic between four points.
  double operator()(double v) const {
    const double x = (v - from_) / step_;
    const int first = std::clamp(static_cast<int>(x) - 1, 0, kPoints - 4);
    const double s = x - first;
    const auto f = [&](int k) { return values_[static_cast<std::size_t>(first + k)]; };
    return -f(0) * (s - 1) * (s - 2) * (s - 3) / 6 + f(1) * s * (s - 2) * (s - 3) / 2 -
           f(2) * s * (s - 1) * (s - 3) / 2 + f(3) * s * (s - 1) * (s - 2) / 6;
  }

  /// With the square of a normal number added: over that number, so that nothing is singular.
  double after_one_more(double v) const {
    const double low = v > to() ? std::sqrt(v - to()) : 0.0, high = std::min(std::sqrt(v - from_), 9.0);
    if (!(low < high)) return 0.0;
    const auto integrand = [&](double z) { return std::exp(-0.5 * z * z) * (*this)(v - z * z); };
    return std::sqrt(2.0 / std::numbers::pi) *
           boost::math::quadrature::gauss<double, 60>::integrate(integrand, low, high);
  }

  /// Simpson's rule.
  double share() const {
    double sum = values_.front() + values_.back();
    for (int i = 1; i + 1 < kPoints; ++i) sum += (i % 2 == 1 ? 4.0 : 2.0) * values_[static_cast<std::size_t>(i)];
    return sum * step_ / 3.0;
  }

 private:
  static constexpr int kPoints = 401;
  double from_, step_;
  std::array<double, kPoints> values_{};
};

/// Integral of density * (coverage of the interval) where series end, from `from`, where the density begins
/// like a root, to `to`.
template <typename Density>
double covered(const Density& density, double from, double to, int n, double critical) {
  const auto integrand = [&](double x) {
    const double v = from + x * x;
    return 2.0 * x * density(v) * held(critical * std::sqrt(v / (n - 1.0) / n), n);
  };
  return boost::math::quadrature::gauss<double, 30>::integrate(integrand, 0.0, std::sqrt(to - from));
}

SequentialCoverage coverage_of(double half_width, const CriticalValue& critical) {
  constexpr int kFirst = host::kMinSequentialShots, kLast = 600;
  SequentialCoverage result;
  result.half_width = half_width;
  result.known_shots = square(1.959964 / half_width);
  const auto ends_below = [&](int n) { return (n - 1.0) * n * square(half_width / critical(n)); };
  const auto top = [&](int n) { return std::max(ends_below(n) + 1.0, n + 45.0 + 9.0 * std::sqrt(2.0 * n)); };
  const boost::math::chi_squared first(kFirst - 1);
  const auto density = [&](double v) { return v > 0.0 ? boost::math::pdf(first, v) : 0.0; };
  double going_on = 1.0 - boost::math::cdf(first, ends_below(kFirst));
  result.ends_at_first = 1.0 - going_on;
  result.mean_shots = kFirst * result.ends_at_first;
  result.coverage = covered(density, 0.0, ends_below(kFirst), kFirst, critical(kFirst));
  Continuing now(ends_below(kFirst), top(kFirst));
  now.fill(density);
  int n = kFirst;
  while (going_on > 1e-7 && n < kLast) {
    ++n;
    const auto with_one_more = [&](double v) { return now.after_one_more(v); };
    Continuing next(ends_below(n), top(n));
    next.fill(with_one_more);
    result.coverage += covered(with_one_more, now.from(), ends_below(n), n, critical(n));
    result.mean_shots += n * (going_on - next.share());
    going_on = next.share();
    now = next;
  }
  result.mean_shots += n * going_on;
  result.coverage += 0.95 * going_on;
  return result;
}

}  // namespace

SequentialCoverage sequential_coverage(double half_width) {
  const auto by_the_rule = [](int n) { return std::sqrt(n) * host::sequential_half_width(1.0, 0.0, n); };
  const auto students = [](int n) { return std::sqrt(n) * host::mean_half_width(1.0, 0.0, n); };
  SequentialCoverage result = coverage_of(half_width, by_the_rule);
  result.plain_coverage = coverage_of(half_width, students).coverage;
  return result;
}

namespace {

/// A scale of 1 % moves the mean by `shared`.
host::Series series_with(double shared, const std::vector<double>& values) {
  host::Series series;
  for (const double value : values) {
    host::Shot shot;
    shot.readout.value[reduction::Quantity::e] = value;
    reduction::BudgetSource scale{.source = reduction::Source::scale, .input_sd = 1.0, .input_unit = "%"};
    scale.effect[static_cast<std::size_t>(reduction::Quantity::e)] = shared;
    shot.budget.sources = {scale};
    series.add(shot);
  }
  return series;
}

bool is_found(const PowerCase& c, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double shared = c.shared_sd * normal(random);
  std::vector<double> first, second;
  for (int i = 0; i < c.shots; ++i) {
    first.push_back(c.difference + shared + c.first_sd * normal(random));
    second.push_back(c.second_sd * normal(random));
  }
  const auto comparison = host::compare(series_with(c.shared_sd, first), series_with(0.0, second));
  return comparison.of(reduction::Quantity::e)->decided;
}

}  // namespace

std::vector<PowerCase> run_power(int pairs, std::uint64_t seed) {
  std::vector<PowerCase> cases;
  for (const double asked : {0.5, 0.8, 0.9, 0.95})
    for (const auto& [second_sd, shared_sd, difference] :
         {std::array{1.0, 0.0, 1.5}, std::array{1.0, 0.0, 0.5}, std::array{3.0, 0.0, 1.5},
          std::array{1.0, 0.2, 1.0}, std::array{2.0, 0.3, 1.5}})
      cases.push_back({1.0, second_sd, shared_sd, difference, asked});
  std::mt19937_64 random(seed);
  for (PowerCase& c : cases) {
    c.shots = host::shots_for_difference({{c.first_sd}, {c.second_sd}, c.shared_sd}, c.difference, c.asked)->shots;
    const host::TwoMeans means{square(c.first_sd), square(c.second_sd), square(c.shared_sd)};
    c.promised = means.power(c.difference, c.shots, c.shots);
    int found = 0;
    for (int i = 0; i < pairs; ++i) found += is_found(c, random) ? 1 : 0;
    c.found = static_cast<double>(found) / pairs;
  }
  return cases;
}

}  // namespace strobe::studies
