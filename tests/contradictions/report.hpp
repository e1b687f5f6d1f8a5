// Tallies in words: tables for people, JSON lines for programs.
#pragma once

#include <string>
#include <vector>

#include "tests/contradictions/tally.hpp"

namespace strobe::contradictions {

struct Row {
  Run run;
  Tally tally;
};

std::string table(const std::vector<Row>& rows);
/// Each alarm's share on undisturbed shots.
std::string false_flags(const Row& undisturbed);
std::string coverage_table(const Row& row);
std::string json_line(const Row& row);
/// The frame with its truth beside it, on one line; `strobe reduce --format frame` reads it.
std::string shot_line(const Shot& shot);

}  // namespace strobe::contradictions
