// JSON lines as the programs print and log them. std::runtime_error names the line that is not JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace strobe::testing {

/// One value a line; empty lines are skipped. A last line without its line end counts if it is whole.
std::vector<nlohmann::json> parse_json_lines(const std::string& text);

std::vector<nlohmann::json> read_json_lines(const std::filesystem::path& path);

/// Cells of comma-separated lines without quotes; the first line names the columns.
struct CsvTable {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;

  /// Place of a column. std::runtime_error if there is none of that name.
  std::size_t column(const std::string& name) const;
};

CsvTable read_csv(const std::filesystem::path& path);

}  // namespace strobe::testing
