// The studies as one figure of error against cost, drawn by gnuplot.
#pragma once

#include <string>
#include <vector>

#include "common/result.hpp"
#include "tests/studies/trade/study.hpp"

namespace strobe::studies::trade {

/// Writes the script NAME.gp, data included, and has it draw NAME.svg and NAME.png.
/// Fails with one line if gnuplot is missing or does not draw.
Result<void> plot(const std::vector<Study>& studies, const std::string& name);

/// The script alone. Pure.
std::string script_text(const std::vector<Study>& studies, const std::string& name);

}  // namespace strobe::studies::trade
