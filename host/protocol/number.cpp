#include "host/protocol/number.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/reduction/uncertainty.hpp"
#include "common/statistics/distributions.hpp"

namespace strobe::protocol {

Number function_of(double value, std::initializer_list<std::pair<const Number*, double>> arguments) {
  Number result{value};
  for (const auto& [argument, derivative] : arguments)
    for (const auto& [source, effect] : argument->effects) result.effects[source] += derivative * effect;
  return result;
}

int Sources::find(const std::string& identity, const Source& source) {
  const auto [found, is_new] = indices_.emplace(identity, static_cast<int>(sources_.size()));
  if (is_new) sources_.push_back(source);
  return found->second;
}

int Sources::group(const std::string& identity, double degrees_of_freedom) {
  const auto [found, is_new] = groups_.emplace(identity, static_cast<int>(freedoms_.size()));
  if (is_new) freedoms_.push_back(degrees_of_freedom);
  return found->second;
}

double Sources::sd(const Number& number) const {
  double variance = 0.0;
  for (const auto& [source, effect] : number.effects) variance += effect * effect;
  return std::sqrt(variance);
}

std::optional<double> Sources::degrees_of_freedom(const Number& number) const {
  std::map<int, double> variances;
  double variance = 0.0, sum = 0.0;
  for (const auto& [source, effect] : number.effects) {
    variance += effect * effect;
    const int group = sources_[static_cast<std::size_t>(source)].group;
    if (group >= 0) variances[group] += effect * effect;
  }
  for (const auto& [group, own] : variances) sum += own * own / freedoms_[static_cast<std::size_t>(group)];
  if (!(sum > 0.0)) return std::nullopt;
  return variance * variance / sum;
}

double Sources::expanded(const Number& number) const {
  const double freedom = degrees_of_freedom(number).value_or(std::numeric_limits<double>::infinity());
  return sd(number) * statistics::student_t_half_width(reduction::kExpandedLevel, freedom);
}

std::vector<host::BudgetLine> Sources::budget(const Number& number) const {
  std::vector<host::BudgetLine> lines;
  const double all = sd(number);
  for (const auto& [index, effect] : number.effects) {
    const Source& source = sources_[static_cast<std::size_t>(index)];
    if (effect == 0.0) continue;
    auto line = std::ranges::find(lines, source.label, &host::BudgetLine::source);
    if (line == lines.end()) {
      line = lines.emplace(lines.end());
      line->source = source.label;
      line->type = source.type;
      line->shared = source.shared;
      line->input_sd = source.input_sd;
      line->input_unit = source.input_unit;
      if (source.input_sd > 0.0) line->sensitivity = effect / source.input_sd;
      if (source.group >= 0) line->degrees_of_freedom = freedoms_[static_cast<std::size_t>(source.group)];
    } else {
      line->sensitivity.reset();
      line->input_sd = 0.0;
    }
    line->effect = std::hypot(line->effect, effect);
  }
  for (host::BudgetLine& line : lines) line.share = line.effect * line.effect / (all * all);
  std::ranges::stable_sort(lines, std::greater(), &host::BudgetLine::effect);
  return lines;
}

Number Sources::mean(const std::string& kind, const std::vector<std::pair<std::string, Number>>& items) {
  const double n = static_cast<double>(items.size());
  if (items.size() == 1) return items.front().second;
  Number mean;
  std::map<int, int> items_of;
  std::string names = kind;
  for (const auto& [name, item] : items) {
    mean.value += item.value / n;
    names += "\n" + name;
    for (const auto& [source, effect] : item.effects) {
      mean.effects[source] += effect / n;
      ++items_of[source];
    }
  }
  double own = 0.0, scattered = 0.0;  // variances of the mean
  std::map<int, double> kept;
  for (const auto& [source, effect] : mean.effects) {
    const bool replaced = items_of[source] < 2 && !sources_[static_cast<std::size_t>(source)].shared;
    if (replaced)
      own += effect * effect;
    else
      kept.emplace(source, effect);
  }
  for (const auto& [name, item] : items) scattered += std::pow(item.value - mean.value, 2) / (n * (n - 1.0));
  if (own > scattered) return mean;
  mean.effects = std::move(kept);
  const Source scatter{"scatter of the " + kind, host::EvaluationType::a, false, 0.0, "",
                       group(names, n - 1.0)};
  for (const auto& [name, item] : items)
    mean.effects[find(kind + "\n" + name, scatter)] += (item.value - mean.value) / std::sqrt(n * (n - 1.0));
  return mean;
}

}  // namespace strobe::protocol
