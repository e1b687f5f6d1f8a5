#include <algorithm>
#include <array>

#include "common/data/csv.hpp"
#include "common/frontier/frontier.hpp"

namespace strobe::frontier {

namespace {

constexpr std::array<std::string_view, 7> kColumns{"study", "method",     "parameter", "cost_us",
                                                   "error", "error_unit", "note"};
constexpr std::array<std::string_view, 4> kRangeColumns{"study", "quantity", "lowest", "highest"};

/// One line's cells, read by column; the first thing wrong is kept.
class Cells {
 public:
  Cells(const data::CsvRow& row, std::span<const std::string_view> columns, std::string_view source)
      : row_(row), columns_(columns), source_(source) {}

  std::string text(std::size_t column) {
    const std::string_view cell = row_.cells[column];
    if (!std::ranges::all_of(cell, [](char c) { return c >= ' ' && c <= '~'; }))
      wrong(column, "has characters that are not printable");
    return std::string(cell);
  }

  std::string name(std::size_t column) {
    if (row_.cells[column].empty()) wrong(column, "is missing");
    return text(column);
  }

  double number(std::size_t column) {
    const auto value = data::parse_number(row_.cells[column], source_, row_.line, columns_[column]);
    if (!value && !error_) error_ = value.error();
    return value.value_or(0.0);
  }

  void wrong(std::size_t column, std::string_view what) {
    if (!error_) error_ = data::csv_error(source_, row_.line, columns_[column], what).value();
  }

  const std::optional<Error>& error() const { return error_; }

 private:
  const data::CsvRow& row_;
  std::span<const std::string_view> columns_;
  std::string_view source_;
  std::optional<Error> error_;
};

}  // namespace

Result<std::vector<Row>> parse_frontier(std::string_view text, std::string_view source) {
  const auto lines = data::parse_csv(text, source, kColumns);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<Row> rows;
  for (const data::CsvRow& line : *lines) {
    Cells cells(line, kColumns, source);
    Row row{.study = cells.name(0),
            .method = cells.name(1),
            .parameter = cells.text(2),
            .cost_us = cells.number(3),
            .error = cells.number(4),
            .error_unit = cells.name(5),
            .note = cells.text(6)};
    if (!(row.cost_us > 0.0)) cells.wrong(3, "must be above 0");
    if (!(row.error >= 0.0)) cells.wrong(4, "must be at least 0");
    for (const Row& other : rows) {
      if (other.study != row.study) continue;
      if (other.method == row.method && other.parameter == row.parameter)
        cells.wrong(1, label(row) + " is there twice");
      if (other.error_unit != row.error_unit)
        cells.wrong(5, "differs from " + other.error_unit + " in the same study");
    }
    if (cells.error()) return tl::unexpected(*cells.error());
    rows.push_back(std::move(row));
  }
  return rows;
}

Result<std::vector<Range>> parse_ranges(std::string_view text, std::string_view source) {
  const auto lines = data::parse_csv(text, source, kRangeColumns);
  if (!lines) return tl::unexpected(lines.error());
  std::vector<Range> ranges;
  for (const data::CsvRow& line : *lines) {
    Cells cells(line, kRangeColumns, source);
    Range range{.study = cells.name(0),
                .quantity = cells.name(1),
                .lowest = cells.number(2),
                .highest = cells.number(3)};
    if (range.lowest > range.highest) cells.wrong(3, "is below lowest");
    for (const Range& other : ranges) {
      if (other.study == range.study && other.quantity == range.quantity)
        cells.wrong(1, range.quantity + " is there twice");
    }
    if (cells.error()) return tl::unexpected(*cells.error());
    ranges.push_back(std::move(range));
  }
  return ranges;
}

}  // namespace strobe::frontier
