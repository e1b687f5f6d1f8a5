#include "host/interlaboratory/scores.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace strobe::interlaboratory {

namespace {

constexpr int kMaxIterations = 10'000;
constexpr double kUncertainShare = 0.3;  ///< ISO 13528:2015, 9.2.1: below it is negligible

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 != 0) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Of values drawn in to 1.5 sd of the mean; 1.134 makes up for what that takes from a normal distribution's.
RobustMean drawn_in(std::span<const double> values, const RobustMean& last) {
  std::vector<double> kept;
  for (const double value : values)
    kept.push_back(std::clamp(value, last.mean - 1.5 * last.sd, last.mean + 1.5 * last.sd));
  const auto count = static_cast<double>(kept.size());
  const double mean = std::accumulate(kept.begin(), kept.end(), 0.0) / count;
  double squares = 0.0;
  for (const double value : kept) squares += (value - mean) * (value - mean);
  return {mean, 1.134 * std::sqrt(squares / (count - 1.0))};
}

std::optional<RobustMean> consensus_without(std::span<const LaboratoryResult> results,
                                            const std::string& reference) {
  std::vector<double> values;
  for (const LaboratoryResult& result : results)
    if (result.laboratory != reference) values.push_back(result.value);
  return robust_mean(values);
}

Scores scores_of(const LaboratoryResult& result, const Agreement& agreement) {
  const AssignedValue& assigned = agreement.assigned;
  if (result.laboratory == assigned.reference) return {};
  const double deviation = result.value - assigned.value;
  Scores scores;
  scores.zeta = deviation / std::hypot(result.standard_uncertainty, assigned.standard_uncertainty);
  if (!assigned.reference.empty())
    scores.en = deviation / std::hypot(result.expanded_uncertainty, assigned.expanded_uncertainty);
  if (agreement.assessment_sd)
    scores.z = deviation / std::hypot(*agreement.assessment_sd,
                                      agreement.with_uncertainty ? assigned.standard_uncertainty : 0.0);
  return scores;
}

}  // namespace

std::optional<RobustMean> robust_mean(std::span<const double> values) {
  if (values.size() < 3) return std::nullopt;
  const double median = median_of({values.begin(), values.end()});
  std::vector<double> deviations;
  for (const double value : values) deviations.push_back(std::abs(value - median));
  RobustMean estimate{median, 1.483 * median_of(std::move(deviations))};
  for (int i = 0; i < kMaxIterations && estimate.sd > 0.0; ++i) {
    const RobustMean next = drawn_in(values, estimate);
    const double moved = std::max(std::abs(next.mean - estimate.mean), std::abs(next.sd - estimate.sd));
    estimate = next;
    if (moved <= 1e-12 * next.sd) return estimate;
  }
  return std::nullopt;
}

Performance judge_en(double en) {
  return std::abs(en) <= 1.0 ? Performance::satisfactory : Performance::unsatisfactory;
}

Performance judge_z(double z) {
  if (std::abs(z) <= 2.0) return Performance::satisfactory;
  return std::abs(z) < 3.0 ? Performance::questionable : Performance::unsatisfactory;
}

std::string_view name(Performance performance) {
  switch (performance) {
    case Performance::satisfactory:
      return "satisfactory";
    case Performance::questionable:
      return "questionable";
    case Performance::unsatisfactory:
      break;
  }
  return "unsatisfactory";
}

std::optional<Agreement> compare(std::span<const LaboratoryResult> results, const Terms& terms) {
  if (results.size() < 2) return std::nullopt;
  const std::string reference =
      terms.reference.empty() && results.size() == 2 ? results.front().laboratory : terms.reference;
  const auto consensus = consensus_without(results, reference);
  Agreement agreement;
  agreement.assessment_sd = terms.assessment_sd;
  if (!agreement.assessment_sd && consensus) agreement.assessment_sd = consensus->sd;
  if (reference.empty()) {
    if (!consensus) return std::nullopt;
    const double uncertainty = 1.25 * consensus->sd / std::sqrt(static_cast<double>(results.size()));
    agreement.assigned = {consensus->mean, uncertainty, 2.0 * uncertainty, ""};
  } else {
    const auto found = std::ranges::find(results, reference, &LaboratoryResult::laboratory);
    if (found == results.end()) return std::nullopt;
    agreement.assigned = {found->value, found->standard_uncertainty, found->expanded_uncertainty, reference};
  }
  agreement.with_uncertainty = agreement.assessment_sd && agreement.assigned.standard_uncertainty >
                                                              kUncertainShare * *agreement.assessment_sd;
  for (const LaboratoryResult& result : results) agreement.scores.push_back(scores_of(result, agreement));
  return agreement;
}

}  // namespace strobe::interlaboratory
