// The studies in words and files. Pure functions of plain values.
#pragma once

#include <string>
#include <vector>

#include "tests/studies/trade/impact_scenes.hpp"
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

/// What the product chooses by; see common/data/frontier/README.md.
std::string frontier_text(const std::vector<Study>& studies);
std::string ranges_text(const std::vector<Range>& ranges);

}  // namespace strobe::studies::trade
