// The studies in words, files and a figure. Pure functions of plain values.
#pragma once

#include <string>
#include <vector>

#include "host/figures/figure.hpp"
#include "tests/studies/trade/study.hpp"

namespace strobe::studies::trade {

/// For people: each method's cost and errors, and which are dominated by what.
std::string table_text(const Study& study);

/// Whether the product's own methods are below and left of every engine's; empty without engines.
std::string engines_text(const Study& study);

/// All studies, a line a method, with both kinds of error over both sets of scenes.
std::string csv_text(const std::vector<Study>& studies);

/// The same figures, one JSON object a method.
std::string json_lines(const std::vector<Study>& studies);

/// Error against cost, both logarithmic, a panel for each study that is to be drawn; a method at several tolerances or numbers of
/// steps is a line. Grey: the frontier, as steps.
figures::Figure figure_of(const std::vector<Study>& studies);

}  // namespace strobe::studies::trade
