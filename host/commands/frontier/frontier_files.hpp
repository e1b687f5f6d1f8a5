// The measured frontier's files and the demands on it, as the commands take them. Reads files; one thread's.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"

namespace strobe::host {

struct FrontierFiles {
  std::vector<frontier::Row> rows;
  std::vector<frontier::Range> ranges;  ///< none without a ranges.csv
};

/// The file and ranges.csv beside it. Empty: the shipped ones. The error names the file.
Result<FrontierFiles> read_frontier(const std::string& file);

/// The error names the option.
Result<frontier::Demand> parse_demand(const std::string& tolerance, std::optional<double> deadline_us);

}  // namespace strobe::host
