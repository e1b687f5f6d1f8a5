#include "tests/support/json_lines.hpp"

#include <sstream>
#include <stdexcept>

#include "tests/support/temporary_folder.hpp"

namespace strobe::testing {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

}  // namespace

std::vector<nlohmann::json> parse_json_lines(const std::string& text) {
  std::vector<nlohmann::json> values;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty()) continue;
    nlohmann::json value = nlohmann::json::parse(line, nullptr, false);
    if (value.is_discarded()) throw std::runtime_error("not JSON: " + line);
    values.push_back(std::move(value));
  }
  return values;
}

std::vector<nlohmann::json> read_json_lines(const std::filesystem::path& path) {
  return parse_json_lines(read_text(path));
}

std::size_t CsvTable::column(const std::string& name) const {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i] == name) return i;
  throw std::runtime_error("no column " + name);
}

CsvTable read_csv(const std::filesystem::path& path) {
  CsvTable table;
  std::istringstream stream(read_text(path));
  std::string line;
  if (std::getline(stream, line)) table.columns = split(line);
  while (std::getline(stream, line)) table.rows.push_back(split(line));
  return table;
}

}  // namespace strobe::testing
