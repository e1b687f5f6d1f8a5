// Instruction counts: taken by valgrind's callgrind, kept in costs.json by machine and compiler. Single-threaded.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace strobe::costs {

using Counts = std::map<std::string, std::int64_t>;

/// Runs this program's own `run` under callgrind and counts each case's instructions. Fails with one line if valgrind
/// cannot be run or gives other than one count for each name.
Result<Counts> count(const std::vector<std::string>& names);

/// The instructions that a callgrind output file sums up. Returns nullopt if there is no such line.
std::optional<std::int64_t> total_of(const std::string& callgrind_output);

/// "x86_64, GNU 12, -O3": what counts can be compared for.
std::string build();

/// A case costs more than this many times its record: it fails.
inline constexpr double kMaxGrowth = 1.10;

/// One line for each case that grew beyond kMaxGrowth, is not recorded, or is recorded but gone; empty: all is well.
std::vector<std::string> complaints(const Counts& recorded, const Counts& counted);

}  // namespace strobe::costs
