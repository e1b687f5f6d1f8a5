#include "host/assembly/shot_budget.hpp"

#include <algorithm>
#include <cmath>

#include "common/statistics/distributions.hpp"

namespace strobe::host {
namespace {

using reduction::Budget;
using reduction::BudgetSource;
using reduction::kQuantityCount;
using reduction::Quantity;
using reduction::Readout;

double part_sd(const Budget& budget, Quantity q, bool systematic) {
  double sd = 0.0;
  for (const BudgetSource& s : budget.sources)
    if (is_systematic(s.source) == systematic) sd = std::hypot(sd, s.of(q));
  return sd;
}

/// Without Student's factor, as the lines are.
double estimated_sd(const Readout& readout, Quantity q) {
  const double sd = readout.sd[q].value_or(0.0);
  const auto& freedom = readout.degrees_of_freedom[q];
  return freedom && *freedom > 0.0 ? sd / statistics::student_t_sigma(*freedom) : sd;
}

void scale_part(Budget& budget, Quantity q, bool systematic, double to) {
  const double now = part_sd(budget, q, systematic);
  if (!(now > 0.0)) return;
  for (BudgetSource& s : budget.sources)
    if (is_systematic(s.source) == systematic) s.effect[static_cast<std::size_t>(q)] *= to / now;
}

void add_assignments(const Readout& readout, Budget& budget) {
  BudgetSource assignment{.source = reduction::Source::assignment};
  bool any = false;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const double between = readout.assignments->sd[q].value_or(0.0);
    if (!(between > 0.0)) continue;
    any = true;
    const double sd = estimated_sd(readout, q);
    scale_part(budget, q, false, std::sqrt(std::max(0.0, (sd - between) * (sd + between))));
    scale_part(budget, q, true, readout.sd_systematic[q].value_or(0.0));
    assignment.effect[i] = between;
  }
  if (!any) return;
  const auto place = std::ranges::find_if(
      budget.sources, [](const BudgetSource& s) { return s.source > reduction::Source::assignment; });
  budget.sources.insert(place, assignment);
}

}  // namespace

Budget shot_budget(const AssembledShot& shot, const Readout& readout) {
  if (shot.frame.images.empty()) return {};
  auto budget = reduction::uncertainty_budget(shot.frame);
  if (!budget) return {};
  if (readout.assignments) add_assignments(readout, *budget);
  return std::move(*budget);
}

}  // namespace strobe::host
