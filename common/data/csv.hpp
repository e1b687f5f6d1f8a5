// Comma-separated numbers with a required header; no quoting. Errors name "SOURCE:LINE: column: what is
// wrong". Views point into the text given, which must outlive them. Pure; thread-safe; allocates.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::data {

struct CsvRow {
  int line = 0;  ///< 1-based line of the text
  std::vector<std::string_view> cells;
};

/// Rows below a header line that must hold exactly the `columns`, in their order. Blank lines are passed
/// over, a byte order mark, CR before LF and blanks around a cell are taken off. Every row has as many cells
/// as columns.
Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view source,
                                      std::span<const std::string_view> columns);

/// A finite decimal number ("-1.5", "2e-3"). Refused: anything else in the cell, so also "nan", "inf", "1,5",
/// hexadecimal, and numbers too large for a double.
Result<double> parse_number(std::string_view cell, std::string_view source, int line,
                            std::string_view column);

/// "SOURCE:LINE: column: what" as an error.
tl::unexpected<Error> csv_error(std::string_view source, int line, std::string_view column,
                                std::string_view what);

}  // namespace strobe::data
