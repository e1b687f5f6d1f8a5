#include "common/data/contact_set.hpp"

#include <array>
#include <cmath>
#include <set>

#include "common/data/csv.hpp"

namespace strobe::data {

namespace {

constexpr std::array<std::string_view, 4> kColumns{"time_fraction", "x_fraction", "y_fraction",
                                                   "rotation_fraction"};

/// Measured fractions of rotation reach some units (backspin); sums of squares stay finite.
constexpr double kMaxFraction = 1e6;

/// Beyond the contact by what touchdown and lift-off may be off; any further the ball is in the air.
constexpr double kMinTime = -0.05;
constexpr double kMaxTime = 1.05;

Result<ContactRow> parse_row(const CsvRow& row, std::string_view source) {
  std::array<double, 4> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = parse_number(row.cells[i], source, row.line, kColumns[i]);
    if (!value) return tl::unexpected(value.error());
    if (std::abs(*value) >= kMaxFraction)
      return csv_error(source, row.line, kColumns[i], "is not a fraction: 1e6 or more");
    values[i] = *value;
  }
  if (values[0] < kMinTime || values[0] > kMaxTime)
    return csv_error(source, row.line, kColumns[0], "must be from -0.05 to 1.05: 0 is touchdown, 1 lift-off");
  return ContactRow{values[0], values[1], values[2], values[3]};
}

}  // namespace

bool is_end_point(const ContactRow& row) {
  return row == ContactRow{0.0, 0.0, 0.0, 0.0} || row == ContactRow{1.0, 1.0, 0.0, 1.0};
}

bool is_interior(const ContactRow& row) {
  return !is_end_point(row) && row.time_fraction >= 0.0 && row.time_fraction <= 1.0;
}

Result<ContactSet> parse_contact_csv(std::string_view text, std::string_view source) {
  const auto rows = parse_csv(text, source, kColumns);
  if (!rows) return tl::unexpected(rows.error());
  if (rows->empty()) return csv_error(source, 1, "", "has no rows below the header");
  ContactSet set{.name = std::string(source), .rows = {}};
  std::set<std::array<double, 4>> seen;
  for (const CsvRow& cells : *rows) {
    const auto row = parse_row(cells, source);
    if (!row) return tl::unexpected(row.error());
    const bool added =
        seen.insert({row->time_fraction, row->x_fraction, row->y_fraction, *row->rotation_fraction}).second;
    added ? set.rows.push_back(*row) : void(++set.repeated);
  }
  return set;
}

}  // namespace strobe::data
