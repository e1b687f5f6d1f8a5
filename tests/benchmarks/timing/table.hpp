// Rows of figures, printed as a table, as JSON, or as CSV.
#pragma once

#include <string>
#include <vector>

#include "tests/benchmarks/timing/sample.hpp"

namespace strobe::benchmarks::timing {

struct Row {
  std::string load, what;
  std::string freezes;  ///< "left out" or "included"
  Percentiles lateness;
  double cpu_percent = -1.0;  ///< negative: not measured
  std::string ratio;          ///< of p50/p99/p99.9/max to the reference's; empty: not computed
};

/// Each of the first's percentiles over the second's, as "0.001 0.02 0.1 0.9".
std::string ratios(const Percentiles& of, const Percentiles& to);

/// `ratio_to` heads the ratios.
void print_rows(const std::vector<Row>& rows, bool json, const std::string& ratio_to = "over cyclictest's");
/// std::runtime_error if it cannot be written.
void write_csv(const std::string& path, const std::vector<Row>& rows);

}  // namespace strobe::benchmarks::timing
