// Predicted against measured spin of published bounces. Pure; thread-safe; allocates.
#pragma once

#include <vector>

#include "host/bounces/report.hpp"
#include "host/thesis/figures/plot.hpp"

namespace strobe::bounces {

/// A panel for tennis balls, one for solid balls, where there are any; a series for each model, besides the line on which predicted is
/// measured. Topspin counts positive.
report::Figure spin_figure(const std::vector<Row>& rows);

}  // namespace strobe::bounces
