// The study's results: tables as text, and JSON lines.
#pragma once

#include <string>

#include "tests/studies/thesis/study.hpp"

namespace strobe::studies {

/// The constants of each pair of spins.
std::string constants_table(const Predictions& predictions);

/// One row for each condition: every number of Tables 5 to 10 as predicted, with its z.
std::string condition_table(std::span<const Cell> cells);

/// rms z, share within 2 and cells beyond 3: one line. vx and omega at lift-off, the same with vy, and all
/// numbers that are not inputs.
std::string summary_header();
std::string summary_line(const std::string& name, std::span<const Cell> cells);

/// The cells with |z| > 3 that are not inputs, each with its reason.
std::string beyond_3(const Predictions& predictions);

/// The reason of a cell with |z| > 3, found by hand in the tables.
std::string reason(const Cell& cell);

std::string json_lines(const std::string& name, std::span<const Cell> cells);

}  // namespace strobe::studies
