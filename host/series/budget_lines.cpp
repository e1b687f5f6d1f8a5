#include "host/series/budget_lines.hpp"

#include <cmath>

namespace strobe::host {
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

}  // namespace strobe::host
