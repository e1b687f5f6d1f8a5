#include "common/data/printed_values.hpp"

#include <array>
#include <cmath>

#include "common/data/csv.hpp"

namespace strobe::thesis {

namespace {

constexpr std::array<std::string_view, 6> kColumns{"table", "set", "quantity", "unit", "value", "provenance"};

double last_digit_of(std::string_view number) {
  const auto point = number.find('.');
  if (point == std::string_view::npos) return 1.0;
  return std::pow(10.0, -static_cast<double>(number.size() - point - 1));
}

}  // namespace

Result<std::vector<PrintedValue>> parse_printed_values(std::string_view text, std::string_view source) {
  const auto rows = data::parse_csv(text, source, kColumns);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<PrintedValue> values;
  for (const data::CsvRow& row : *rows) {
    for (std::size_t i = 0; i < kColumns.size(); ++i)
      if (row.cells[i].empty()) return data::csv_error(source, row.line, kColumns[i], "is missing");
    const auto value = data::parse_number(row.cells[4], source, row.line, kColumns[4]);
    if (!value) return tl::unexpected(value.error());
    const auto cell = [&row](std::size_t i) { return std::string(row.cells[i]); };
    values.push_back({cell(0), cell(1), cell(2), cell(3), *value, last_digit_of(row.cells[4]), cell(5)});
  }
  return values;
}

Result<std::vector<PrintedValue>> load_printed_values(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "printed_values.csv";
  const auto text = data::read_text(path);
  if (!text) return tl::unexpected(text.error());
  return parse_printed_values(*text, path.string());
}

const PrintedValue* find(std::span<const PrintedValue> values, std::string_view table, std::string_view set,
                         std::string_view quantity) {
  for (const PrintedValue& value : values)
    if (value.table == table && value.set == set && value.quantity == quantity) return &value;
  return nullptr;
}

}  // namespace strobe::thesis
