// Comma-separated values (RFC 4180), read and written: cells in double quotes may hold commas, line breaks
// and, doubled, quotes. Every program and library here that reads or writes such text does it by these
// functions. Errors read "SOURCE:LINE: column: what is wrong". Pure; thread-safe; they allocate.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::data {

struct CsvRow {
  int line = 0;  ///< 1-based line of the text on which it begins
  std::vector<std::string> cells;
};

/// The rows of a text, without the quotes around cells; at least one cell each. Rows of one empty cell are
/// skipped; a byte order mark at the begin and CR outside quotes are removed. A quote that does not end ends
/// with the text.
std::vector<CsvRow> csv_rows(std::string_view text);

/// The cells of a text that is one row; one empty cell of an empty text.
std::vector<std::string> csv_cells(std::string_view row);

/// A cell as it stands in a row: in quotes where need be.
std::string csv_cell(std::string_view text);

/// Rows below a header line that must hold exactly the `columns`, in their order. Blank lines are skipped,
/// blanks around a cell removed. Every row has as many cells as columns.
Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view source,
                                      std::span<const std::string_view> columns);

/// A finite decimal number ("-1.5", "2e-3"). Fails on anything else in the cell: "nan", "inf", "1,5",
/// hexadecimal, numbers too large for a double.
Result<double> parse_number(std::string_view cell, std::string_view source, int line,
                            std::string_view column);

/// "SOURCE:LINE: column: what" as an error; without the column if that is empty.
tl::unexpected<Error> csv_error(std::string_view source, int line, std::string_view column,
                                std::string_view what);

}  // namespace strobe::data
