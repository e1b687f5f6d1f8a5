#include "common/data/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace strobe::data {

namespace {

std::string trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const auto first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(kBlanks) - first + 1));
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

/// Takes one row off the text. line: where it begins, then where the next one does.
CsvRow take_row(std::string_view& text, int& line) {
  CsvRow row{.line = line, .cells = {""}};
  bool quoted = false;
  while (!text.empty()) {
    const char c = text.front();
    text.remove_prefix(1);
    if (c == '\n') ++line;
    if (c == '"') {
      const bool doubled = quoted && text.starts_with('"');
      if (doubled) {
        row.cells.back() += c;
        text.remove_prefix(1);
      } else {
        quoted = !quoted;
      }
    } else if (quoted || (c != ',' && c != '\n' && c != '\r')) {
      row.cells.back() += c;
    } else if (c == ',') {
      row.cells.emplace_back();
    } else if (c == '\n') {
      break;
    }
  }
  return row;
}

}  // namespace

std::vector<CsvRow> csv_rows(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<CsvRow> rows;
  int line = 1;
  while (!text.empty()) {
    CsvRow row = take_row(text, line);
    if (row.cells.size() > 1 || !row.cells.front().empty()) rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::string> csv_cells(std::string_view row) {
  int line = 1;
  return take_row(row, line).cells;
}

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) cell.append(c == '"' ? 2 : 1, c);
  return cell + "\"";
}

tl::unexpected<Error> csv_error(std::string_view source, int line, std::string_view column,
                                std::string_view what) {
  std::string message(source);
  message.append(":").append(std::to_string(line)).append(": ");
  if (!column.empty()) message.append(column).append(": ");
  return fail(message.append(what));
}

Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view source,
                                      std::span<const std::string_view> columns) {
  std::vector<CsvRow> rows = csv_rows(text);
  for (CsvRow& row : rows) std::ranges::transform(row.cells, row.cells.begin(), trimmed);
  std::erase_if(rows, [](const CsvRow& row) { return row.cells.size() == 1 && row.cells.front().empty(); });
  if (rows.empty()) return csv_error(source, 1, "", "is empty; the header must be " + joined(columns));
  if (!std::ranges::equal(rows.front().cells, columns))
    return csv_error(source, rows.front().line, "", "the header must be " + joined(columns));
  rows.erase(rows.begin());
  for (const CsvRow& row : rows) {
    if (row.cells.size() == columns.size()) continue;
    const std::string_view at = row.cells.size() < columns.size() ? columns[row.cells.size()] : "";
    return csv_error(
        source, row.line, at,
        "has " + std::to_string(row.cells.size()) + " columns instead of " + std::to_string(columns.size()));
  }
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

}  // namespace strobe::data
