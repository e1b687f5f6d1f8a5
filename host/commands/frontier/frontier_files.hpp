// The measured frontier's files and the options --tolerance and --deadline-us. Reads files; single-threaded.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/frontier/frontier.hpp"

namespace strobe::host {

struct FrontierFiles {
  std::vector<frontier::Row> rows;
  std::vector<frontier::Range> ranges;  ///< empty without a ranges.csv
};

/// Reads the file and ranges.csv beside it; the shipped ones if `file` is empty. The error names the file.
Result<FrontierFiles> read_frontier(const std::string& file);

/// Parses the two options. The error names the option.
Result<frontier::Requirement> parse_requirement(const std::string& tolerance,
                                                std::optional<double> deadline_us);

}  // namespace strobe::host
