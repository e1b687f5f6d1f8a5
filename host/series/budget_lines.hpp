// One shot's budget of one quantity, line by line. Pure; thread-safe.
#pragma once

#include <vector>

#include "common/reduction/uncertainty.hpp"
#include "host/series/series_summary.hpp"

namespace strobe::host {

/// Without lines that do nothing to the quantity; the map's errors as one.
std::vector<BudgetLine> budget_lines(const reduction::Budget& budget, reduction::Quantity q);

}  // namespace strobe::host
