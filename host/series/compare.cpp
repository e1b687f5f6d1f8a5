#include "host/series/compare.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"
#include "host/series/sequential.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;

double squared(double x) { return x * x; }

/// By what a comparison allows for series that were ended by what they said (sequential.hpp).
double inflation_of(const SeriesSummary& summary, const QuantitySummary& s) {
  return summary.until_known.empty() ? 1.0 : sequential_inflation(s.n);
}

/// The further shots of each by which the difference is found.
void count_shots(const TwoSeries& series, double power, QuantityDifference& d) {
  d.power = power;
  d.of_each = shots_for_difference(series, d.asked, power);
  if (!d.of_each) return;
  d.more_first = std::max(0, d.of_each->shots - series.fired_first);
  d.more_second = std::max(0, d.of_each->shots - series.fired_second);
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

struct AskedSize {
  std::optional<double> asked;
  double power = kPower;
};

QuantityDifference difference_of(const QuantitySummary& a, const QuantitySummary& b,
                                 const std::array<double, 2>& inflations, double shared,
                                 const AskedSize& size) {
  const TwoMeans means{squared(*a.scatter_sd), squared(*b.scatter_sd), shared};
  const TwoMeans inflated{squared(inflations[0] * *a.scatter_sd), squared(inflations[1] * *b.scatter_sd),
                          shared};
  QuantityDifference d;
  d.difference = a.mean - b.mean;
  d.standard_error = std::hypot(*a.standard_error, *b.standard_error);
  d.shared_sd = std::sqrt(shared);
  d.total_sd = std::sqrt(means.total_variance(a.n, b.n));
  const double freedom = inflated.degrees_of_freedom(a.n, b.n);
  const double sd = std::sqrt(inflated.total_variance(a.n, b.n));
  if (std::isfinite(freedom)) d.degrees_of_freedom = freedom;
  d.expanded_uncertainty = sd * statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
  d.decided = std::abs(d.difference) > d.expanded_uncertainty;
  if (sd > 0.0)
    d.p_value = statistics::student_t_tail(std::abs(d.difference) / sd, freedom);
  else
    d.p_value = d.difference == 0.0 ? 1.0 : 0.0;
  d.is_asked = size.asked.has_value();
  d.asked = size.asked.value_or(std::abs(d.difference));
  count_shots({{*a.scatter_sd, a.n - 1.0}, {*b.scatter_sd, b.n - 1.0}, d.shared_sd, a.n, b.n}, size.power, d);
  return d;
}

}  // namespace

Comparison compare(const Series& first, const Series& second, const reduction::Quantities& asked,
                   double power) {
  Comparison comparison;
  const SeriesSummary a = first.summary(""), b = second.summary("");
  const SharedEffects shared_a = first.shared_effects(), shared_b = second.shared_effects();
  for (std::size_t q = 0; q < kQuantityCount; ++q) {
    const bool known = a.quantities[q].shared_known && b.quantities[q].shared_known;
    if (a.quantities[q].n < 2 || b.quantities[q].n < 2 || !known) continue;
    comparison.quantities[q] = difference_of(
        a.quantities[q], b.quantities[q],
        {inflation_of(a, a.quantities[q]), inflation_of(b, b.quantities[q])},
        shared_variance(shared_a, shared_b, q), {asked[static_cast<reduction::Quantity>(q)], power});
  }
  return comparison;
}

}  // namespace strobe::host
