// What each column of a session's tables holds: one list from which headers are made, and the data dictionary that lies
// beside each table, NAME.csv-metadata.json. Pure functions; thread-safe; they allocate.
// Source: W3C, Metadata Vocabulary for Tabular Data (2015); units by UCUM (ucum.org).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace strobe::host {

struct Column {
  std::string name;
  std::string datatype;  ///< of that vocabulary: "string", "number", "integer", "boolean", "dateTime"
  std::string unit;      ///< UCUM; "1": a pure number; empty: no quantity
  std::string meaning;   ///< one sentence
  char separator = 0;    ///< a cell is a list of values that this separates; 0: one value
};

/// Of results.csv, in its order.
const std::vector<Column>& results_columns();
/// Of flashes.csv, in its order.
const std::vector<Column>& flashes_columns();

/// "utc,boot_id,shot_id"
std::string csv_header(std::span<const Column> columns);

/// The metadata file of a table. title: for a person.
std::string data_dictionary(std::string_view file_name, std::string_view title,
                            std::span<const Column> columns);

}  // namespace strobe::host
