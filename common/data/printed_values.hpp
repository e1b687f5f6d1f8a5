// Printed values of the thesis beyond its Tables 2–10 that are known: single numbers by table, set and
// quantity, each with its provenance. Parsing is pure; load_printed_values() reads a file. Thread-safe;
// allocates.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.hpp"

namespace strobe::thesis {

struct PrintedValue {
  std::string table;  ///< "15", or the name of a source that the thesis cites
  std::string set;    ///< e.g. "zero_23"
  std::string quantity;
  std::string unit;
  double value = 0.0;
  double last_digit = 1.0;  ///< unit of the last digit printed: 0.001 for 1.070
  std::string provenance;
};

/// Columns table,set,quantity,unit,value,provenance.
Result<std::vector<PrintedValue>> parse_printed_values(std::string_view text, std::string_view source);

/// Reads `folder`/printed_values.csv.
Result<std::vector<PrintedValue>> load_printed_values(const std::filesystem::path& folder);

/// Returns nullptr if there is none.
const PrintedValue* find(std::span<const PrintedValue> values, std::string_view table, std::string_view set,
                         std::string_view quantity);

}  // namespace strobe::thesis
