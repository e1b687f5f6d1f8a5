#include "host/series/series.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>

#include "common/reduction/running_statistics.hpp"
#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"
#include "host/series/sequential.hpp"

namespace strobe::host {
namespace {

using reduction::BudgetSource;
using reduction::kQuantityCount;
using reduction::Quantity;
using reduction::Source;

BudgetLine scatter_line(double standard_error, int n) {
  BudgetLine line;
  line.source = "scatter of the shots";
  line.type = EvaluationType::a;
  line.effect = standard_error;
  line.degrees_of_freedom = n - 1;
  return line;
}

/// "scale", and "scale (2)" for the second calibration or ball of the series.
std::string numbered(const SharedSource& source, const SharedEffects& all) {
  const std::string name = reduction::name_of({source.source});
  int which = 0, different = 0;
  for (const auto& [other, effect] : all) {
    if (other.source != source.source || other.number != source.number) continue;
    ++different;
    if (other.identity <= source.identity) ++which;
  }
  return different > 1 ? name + " (" + std::to_string(which) + ")" : name;
}

/// The map's errors are many, and none of them means anything to a person: one line.
void add_map_line(const SharedEffects& shared, std::size_t q, std::vector<BudgetLine>& lines) {
  BudgetLine line;
  line.source = "map from photograph to plane";
  line.shared = true;
  for (const auto& [source, effect] : shared)
    if (source.source == Source::map) line.effect = std::hypot(line.effect, effect.effect[q]);
  if (line.effect > 0.0) lines.push_back(line);
}

std::vector<BudgetLine> shared_lines(const SharedEffects& shared, std::size_t q) {
  std::vector<BudgetLine> lines;
  for (const auto& [source, effect] : shared) {
    if (source.source == Source::map || effect.effect[q] == 0.0) continue;
    BudgetLine& line = lines.emplace_back();
    line.source = numbered(source, shared);
    line.input_sd = effect.input_sd;
    line.input_unit = effect.input_unit;
    if (effect.input_sd > 0.0) line.sensitivity = effect.effect[q] / effect.input_sd;
    line.effect = std::abs(effect.effect[q]);
    line.shared = true;
  }
  add_map_line(shared, q, lines);
  return lines;
}

/// Combines the lines and says how much each is of it.
void combine(QuantitySummary& s, bool sequential) {
  double variance = 0.0;
  for (const BudgetLine& line : s.budget) variance += line.effect * line.effect;
  for (BudgetLine& line : s.budget) line.share = variance > 0.0 ? line.effect * line.effect / variance : 0.0;
  if (!s.standard_error || !s.shared_known) return;
  s.total_sd = std::sqrt(variance);
  double freedom = std::numeric_limits<double>::infinity();
  if (*s.standard_error > 0.0) {
    const double ratio = variance / (*s.standard_error * *s.standard_error);
    freedom = (s.n - 1) * ratio * ratio;  // Welch-Satterthwaite; what is shared has infinitely many
    s.degrees_of_freedom = freedom;
  }
  s.expanded_uncertainty =
      sequential ? sequential_half_width(*s.scatter_sd, s.shared_sd, s.n)
                 : *s.total_sd * statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
}

/// The court pace is the ITF's for shots as it prescribes them only.
bool counts(const Shot& shot, Quantity q) {
  return shot.readout.value[q] && (q != Quantity::court_pace || shot.readout.court_pace_conforming);
}

void add_if_flagged(OutOfPlane& to, const reduction::Readout& readout, reduction::Flag flag,
                    reduction::SpatialQuantity quantity) {
  if (!readout.flags.has(flag) || !readout.spatial || !(*readout.spatial)[quantity]) return;
  ++to.shots;
  to.sum += (*readout.spatial)[quantity]->value;
}

/// Of "flash 3 would have been 1712 us late: kworker/1:2 (pid 71) ran for 912 us"; empty: none is named.
std::string culprit_in(std::string_view reason) {
  constexpr std::string_view kBefore = " us late: ";
  const std::size_t at = reason.find(kBefore);
  if (at == std::string_view::npos) return {};
  reason.remove_prefix(at + kBefore.size());
  for (const std::string_view after : {" (pid ", " ran for ", " for "})
    reason = reason.substr(0, reason.find(after));
  return std::string(reason);
}

}  // namespace

void Series::add(const Shot& shot) {
  if (shot.rejected) {
    ++rejected_;
    const std::string name = shot.summary ? culprit_in(shot.summary->abort_reason) : std::string();
    if (!name.empty()) ++culprits_[name];
    return;
  }
  ++counted_;
  assert(names_.size() + 1 == static_cast<std::size_t>(counted_));
  if (shot.budget.sources.empty()) shared_known_ = false;
  names_.push_back(shot.full_name());
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto& value = shot.readout.value[static_cast<Quantity>(i)];
    if (!counts(shot, static_cast<Quantity>(i))) continue;
    columns_[i].values.push_back(*value);
    columns_[i].shots.push_back(names_.size() - 1);
  }
  if (!shot.until_known.empty()) until_known_ = shot.until_known;
  using reduction::Flag, reduction::SpatialQuantity;
  add_if_flagged(tilted_, shot.readout, Flag::axis_tilted, SpatialQuantity::spin_axis_tilt_td_deg);
  add_if_flagged(leaving_, shot.readout, Flag::out_of_plane, SpatialQuantity::vz_td_mps);
  add_shared(shot);
}

void Series::add_shared(const Shot& shot) {
  const auto named = shot.readout.record.find("ball_name");
  const std::string& ball =
      shot.ball.empty() && named != shot.readout.record.end() ? named->second : shot.ball;
  for (const BudgetSource& source : shot.budget.sources) {
    if (!is_shared(source.source)) continue;
    const std::string& identity = is_calibration(source.source) ? shot.calibration : ball;
    SharedEffect& sum = sums_[{source.source, source.number, identity}];
    sum.input_sd = source.input_sd;
    sum.input_unit = source.input_unit;
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      if (counts(shot, static_cast<Quantity>(i))) sum.effect[i] += source.effect[i];
  }
}

SharedEffects Series::shared_effects() const {
  SharedEffects means = sums_;
  for (auto& [source, mean] : means) {
    for (std::size_t i = 0; i < kQuantityCount; ++i)
      if (!columns_[i].values.empty()) mean.effect[i] /= static_cast<double>(columns_[i].values.size());
  }
  return means;
}

/// The distance of each shot from the others, in standard deviations of such a distance, is Student's t with
/// n - 2 degrees of freedom, and follows from g, that from the mean of all in their scatter; of the largest
/// of n, Bonferroni's bound is what Grubbs's test uses.
void Series::find_outliers(Quantity q, const QuantitySummary& s, std::vector<SeriesOutlier>& found) const {
  const std::vector<double>& values = of(q).values;
  const auto n = static_cast<double>(values.size());
  if (std::ssize(values) < kMinForOutlier || !(*s.scatter_sd > 0.0)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double g = (values[i] - s.mean) / *s.scatter_sd;
    const double others = (n - 1.0) * (n - 1.0) - n * g * g;  // their sum of squares, times (n - 1)
    if (!(others > 1e-9 * n * n)) continue;                   // they have no scatter
    const double t = g * std::sqrt(n * (n - 2.0) / others);
    if (statistics::student_t_tail(t, n - 2.0) * n < kOutlierLevel)
      found.push_back({names_[of(q).shots[i]], q, t * std::sqrt(n / (n - 1.0))});
  }
}

SeriesSummary Series::summary(std::string name) const {
  SeriesSummary summary;
  summary.name = std::move(name);
  summary.counted = counted_;
  summary.rejected = rejected_;
  summary.culprits = culprits_;
  summary.until_known = until_known_;
  summary.tilted = tilted_;
  summary.leaving = leaving_;
  const SharedEffects shared = shared_effects();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    QuantitySummary& s = summary.quantities[i];
    reduction::RunningStatistics all;
    for (const double v : columns_[i].values) all.add(v);
    s.n = static_cast<int>(all.count());
    if (s.n == 0) continue;
    s.mean = all.mean();
    s.shared_known = shared_known_;
    s.budget = shared_lines(shared, i);
    for (const BudgetLine& line : s.budget) s.shared_sd = std::hypot(s.shared_sd, line.effect);
    if (s.n > 1) {
      s.scatter_sd = all.sample_sd();
      s.standard_error = *s.scatter_sd / std::sqrt(s.n);
      s.budget.insert(s.budget.begin(), scatter_line(*s.standard_error, s.n));
    }
    combine(s, !until_known_.empty());
    find_outliers(static_cast<Quantity>(i), s, summary.outliers);
  }
  return summary;
}

SeriesSummary summarize(std::string name, std::span<const Shot> shots) {
  Series series;
  for (const Shot& shot : shots) series.add(shot);
  return series.summary(std::move(name));
}

namespace {

constexpr std::string_view kMapLine = "map from photograph to plane";

BudgetLine budget_line_of(const reduction::BudgetSource& source, reduction::Quantity q) {
  BudgetLine line;
  line.source = source.source == reduction::Source::map ? std::string(kMapLine) : name_of(source);
  line.type = source.type;
  line.degrees_of_freedom = source.degrees_of_freedom;
  line.shared = is_shared(source.source);
  line.effect = std::abs(source.of(q));
  if (source.source == reduction::Source::map || !(source.input_sd > 0.0)) return line;
  line.input_sd = source.input_sd;
  line.input_unit = source.input_unit;
  line.sensitivity = source.of(q) / source.input_sd;
  return line;
}

}  // namespace

std::vector<BudgetLine> budget_lines(const reduction::Budget& budget, reduction::Quantity q) {
  std::vector<BudgetLine> lines;
  double variance = 0.0;
  for (const reduction::BudgetSource& source : budget.sources) {
    const double effect = source.of(q);
    if (effect == 0.0) continue;
    variance += effect * effect;
    const bool again =
        source.source == reduction::Source::map && !lines.empty() && lines.back().source == kMapLine;
    if (again)
      lines.back().effect = std::hypot(lines.back().effect, effect);
    else
      lines.push_back(budget_line_of(source, q));
  }
  for (BudgetLine& line : lines) line.share = line.effect * line.effect / variance;
  return lines;
}

std::optional<IndividualsLimits> individuals_limits(std::span<const double> values) {
  if (values.size() < kMinForLimits) return std::nullopt;
  double sum = 0.0, ranges = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    if (i > 0) ranges += std::abs(values[i] - values[i - 1]);
  }
  const double mean = sum / static_cast<double>(values.size());
  const double sd = ranges / static_cast<double>(values.size() - 1) / kRangeOfTwo;
  return IndividualsLimits{mean, mean - 3.0 * sd, mean + 3.0 * sd};
}

}  // namespace strobe::host
