#include "common/data/csv.hpp"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>

namespace strobe::data {

namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> cells;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string_view::npos; comma = line.find(',', begin)) {
    cells.push_back(trimmed(line.substr(begin, comma - begin)));
    begin = comma + 1;
  }
  cells.push_back(trimmed(line.substr(begin)));
  return cells;
}

std::string joined(std::span<const std::string_view> columns) {
  std::string text;
  for (const std::string_view column : columns) text.append(text.empty() ? "" : ",").append(column);
  return text;
}

/// What a person sees of a cell that may hold anything: printable, and not a page long.
std::string shown(std::string_view cell) {
  std::string text = "'";
  for (const char c : cell.substr(0, 40)) text += (c >= ' ' && c <= '~') ? c : '?';
  return text.append(cell.size() > 40 ? "...'" : "'");
}

bool same(std::span<const std::string_view> a, std::span<const std::string_view> b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != b[i]) return false;
  return true;
}

}  // namespace

tl::unexpected<Error> csv_error(std::string_view source, int line, std::string_view column,
                                std::string_view what) {
  std::string message(source);
  message.append(":").append(std::to_string(line)).append(": ");
  if (!column.empty()) message.append(column).append(": ");
  return fail(message.append(what));
}

Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view source,
                                      std::span<const std::string_view> columns) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<CsvRow> rows;
  bool header_seen = false;
  int line = 0;
  while (!text.empty()) {
    ++line;
    const auto end = text.find('\n');
    const std::string_view content = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (content.empty()) continue;
    std::vector<std::string_view> cells = split(content);
    if (!header_seen) {
      if (!same(cells, columns)) return csv_error(source, line, "", "the header must be " + joined(columns));
      header_seen = true;
      continue;
    }
    if (cells.size() != columns.size()) {
      std::string what = "has ";
      what.append(std::to_string(cells.size()))
          .append(" columns instead of ")
          .append(std::to_string(columns.size()));
      return csv_error(source, line, cells.size() < columns.size() ? columns[cells.size()] : "", what);
    }
    rows.push_back({line, std::move(cells)});
  }
  if (!header_seen) return csv_error(source, 1, "", "is empty; the header must be " + joined(columns));
  return rows;
}

Result<double> parse_number(std::string_view cell, std::string_view source, int line,
                            std::string_view column) {
  if (cell.empty()) return csv_error(source, line, column, "is missing");
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc::result_out_of_range)
    return csv_error(source, line, column, shown(cell) + " is too large or too small a number");
  if (error != std::errc{} || end != cell.data() + cell.size() || !std::isfinite(value))
    return csv_error(source, line, column, shown(cell) + " is not a number");
  return value;
}

Result<std::string> read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path)) return fail(path.string() + ": cannot be read");
  std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad()) return fail(path.string() + ": cannot be read");
  return text;
}

}  // namespace strobe::data
