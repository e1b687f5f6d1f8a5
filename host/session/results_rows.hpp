// results.csv read back. Pure but for read_results_rows(), which reads a file; thread-safe; allocates.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"
#include "common/shot/shot_key.hpp"

namespace strobe::host {

struct ResultsRow {
  ShotKey key;
  std::string utc;
  bool counts = false;  ///< it is not rejected
  std::string line;     ///< as it stands there, without its end
};

/// Rows of any text: the header and lines that do not begin with a time, a boot and a shot are left out, as is a last line
/// that was cut short. Quoted fields may hold line ends.
std::vector<ResultsRow> parse_results(std::string_view text);

/// Those of a file, of any size; none if there is no such file. Fails with its name if it cannot be read.
Result<std::vector<ResultsRow>> read_results_rows(const std::filesystem::path& file);

}  // namespace strobe::host
