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

/// A line for standard error on the time taken, which never belongs to a result's bytes:
/// "strobe: COMMAND: took 12.3 us at its first call (9.8 us expected of a later one)", and by how much a
/// deadline was missed.
std::string took_line(const std::string& command, double took_us, double expected_us,
                      const frontier::Demand& demand);

}  // namespace strobe::host
