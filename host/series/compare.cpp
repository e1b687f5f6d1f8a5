#include "host/series/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;

constexpr int kMaxShots = 1000000;

/// What of two means' uncertainty shots can lessen, and what they cannot.
struct Variances {
  double first = 0.0, second = 0.0;  ///< of one shot
  double shared = 0.0;

  double total(double n1, double n2) const { return first / n1 + second / n2 + shared; }

  /// Welch-Satterthwaite.
  double freedom(double n1, double n2) const {
    const double a = first / n1, b = second / n2;
    const double uncertain = a * a / (n1 - 1.0) + b * b / (n2 - 1.0);
    const double all = a + b + shared;
    return uncertain > 0.0 ? all * all / uncertain : std::numeric_limits<double>::infinity();
  }

  /// Whether n shots of each find it: its distance from 0 is the interval's half width and the power's
  /// quantile more.
  bool find(double difference, double n1, double n2) const {
    const double nu = freedom(n1, n2);
    const double quantiles = statistics::student_t_half_width(reduction::kExpandedLevel, nu) +
                             statistics::student_t_half_width(2.0 * kPower - 1.0, nu);
    return quantiles * std::sqrt(total(n1, n2)) <= difference;
  }
};

/// The fewest shots of each, no fewer than there are, by which the difference is found.
void count_shots(const Variances& v, int n1, int n2, QuantityDifference& d) {
  const auto found_by = [&](int n) { return v.find(d.asked, std::max(n, n1), std::max(n, n2)); };
  constexpr double kAny = std::numeric_limits<double>::infinity();
  if (!(d.asked > 0.0) || !v.find(d.asked, kAny, kAny)) return;
  int few = 1, many = kMaxShots;
  if (found_by(2)) many = 2;
  while (many - few > 1) {
    const int middle = few + (many - few) / 2;
    (found_by(middle) ? many : few) = middle;
  }
  d.more_first = std::max(0, many - n1);
  d.more_second = std::max(0, many - n2);
}

double shared_variance(const SharedEffects& first, const SharedEffects& second, std::size_t q) {
  std::set<SharedSource> sources;
  for (const auto& [source, effect] : first) sources.insert(source);
  for (const auto& [source, effect] : second) sources.insert(source);
  const auto effect_of = [q](const SharedEffects& effects, const SharedSource& source) {
    const auto found = effects.find(source);
    return found == effects.end() ? 0.0 : found->second.effect[q];
  };
  double variance = 0.0;
  for (const SharedSource& source : sources) {
    const double rest = effect_of(first, source) - effect_of(second, source);
    variance += rest * rest;
  }
  return variance;
}

QuantityDifference difference_of(const QuantitySummary& a, const QuantitySummary& b, double shared,
                                 std::optional<double> asked) {
  const Variances v{*a.scatter_sd * *a.scatter_sd, *b.scatter_sd * *b.scatter_sd, shared};
  QuantityDifference d;
  d.difference = a.mean - b.mean;
  d.standard_error = std::hypot(*a.standard_error, *b.standard_error);
  d.shared_sd = std::sqrt(shared);
  d.total_sd = std::sqrt(v.total(a.n, b.n));
  const double freedom = v.freedom(a.n, b.n);
  if (std::isfinite(freedom)) d.degrees_of_freedom = freedom;
  d.expanded_uncertainty = d.total_sd * statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
  d.decided = std::abs(d.difference) > d.expanded_uncertainty;
  if (d.total_sd > 0.0)
    d.p_value = statistics::student_t_tail(std::abs(d.difference) / d.total_sd, freedom);
  else
    d.p_value = d.difference == 0.0 ? 1.0 : 0.0;
  d.is_asked = asked.has_value();
  d.asked = asked.value_or(std::abs(d.difference));
  count_shots(v, a.n, b.n, d);
  return d;
}

}  // namespace

Comparison compare(const Series& first, const Series& second, const reduction::Quantities& asked) {
  Comparison comparison;
  const SeriesSummary a = first.summary(""), b = second.summary("");
  const SharedEffects shared_a = first.shared_effects(), shared_b = second.shared_effects();
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    const bool known = a.quantities[q].shared_known && b.quantities[q].shared_known;
    if (a.quantities[q].n < 2 || b.quantities[q].n < 2 || !known) continue;
    comparison.quantities[q] =
        difference_of(a.quantities[q], b.quantities[q], shared_variance(shared_a, shared_b, q),
                      asked[static_cast<reduction::Quantity>(q)]);
  }
  return comparison;
}

}  // namespace strobe::host
