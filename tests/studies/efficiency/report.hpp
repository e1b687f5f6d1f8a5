// The efficiency study in words: tables for people, JSON lines for programs.
#pragma once

#include <string>
#include <vector>

#include "tests/studies/efficiency/study.hpp"

namespace strobe::studies {

/// What one scenario gave.
struct Result {
  Scenario scenario;
  std::vector<Method> methods;
  std::vector<Condition> conditions;
};

/// For each method and quantity, over the conditions: rms error/bound, rms error/stated sd, bias, coverage.
std::string summary(const Result& result);

/// How many times larger than `best`'s each method's rms error is: median and range over the conditions.
std::string times_worse(const Result& result);

/// One row per condition, one block per method and measure.
std::string long_table(const Result& result);

/// One object per condition, method and quantity.
std::string json_lines(const Result& result);

}  // namespace strobe::studies
