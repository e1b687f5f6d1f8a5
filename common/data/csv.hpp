// Comma-separated numbers with a required header; no quoting. Errors read "SOURCE:LINE: column: what is
// wrong". Views point into the text given, which must outlive them. Pure but for read_text(); thread-safe;
// allocates.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::data {

struct CsvRow {
  int line = 0;  ///< 1-based line of the text
  std::vector<std::string_view> cells;
};

/// Rows below a header line that must hold exactly the `columns`, in their order. Blank lines are skipped; a
/// byte order mark, CR before LF and blanks around a cell are removed. Every row has as many cells as
/// columns.
Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view source,
                                      std::span<const std::string_view> columns);

/// A finite decimal number ("-1.5", "2e-3"). Fails on anything else in the cell: "nan", "inf", "1,5",
/// hexadecimal, numbers too large for a double.
Result<double> parse_number(std::string_view cell, std::string_view source, int line,
                            std::string_view column);

/// "SOURCE:LINE: column: what" as an error; without the column if that is empty.
tl::unexpected<Error> csv_error(std::string_view source, int line, std::string_view column,
                                std::string_view what);

/// The whole file. Fails with "PATH: cannot be read".
Result<std::string> read_text(const std::filesystem::path& path);

}  // namespace strobe::data
