// Corrections of one contact set.
#include <algorithm>
#include <optional>

#include "common/data/csv.hpp"
#include "common/data/thesis_data.hpp"

namespace strobe::thesis {

namespace {

using data::ContactRow;
using data::ContactSet;

tl::unexpected<Error> mismatch(const Correction& c, std::string_view column, std::string_view what) {
  return data::csv_error("corrections", c.line, column, c.set + ": " + std::string(what));
}

/// The column as an optional number. Returns nullopt if there is no column of that name.
std::optional<std::optional<double>> read_field(const ContactRow& row, std::string_view field) {
  if (field == "time_fraction") return row.time_fraction;
  if (field == "x_fraction") return row.x_fraction;
  if (field == "y_fraction") return row.y_fraction;
  if (field == "rotation_fraction") return row.rotation_fraction;
  return std::nullopt;
}

void write_field(ContactRow& row, std::string_view field, double value) {
  if (field == "time_fraction") row.time_fraction = value;
  if (field == "x_fraction") row.x_fraction = value;
  if (field == "y_fraction") row.y_fraction = value;
  if (field == "rotation_fraction") row.rotation_fraction = value;
}

Result<void> correct_all_rows(ContactSet& set, const Correction& c) {
  if (c.corrected == "sort" && c.field == "row") {
    std::stable_sort(set.rows.begin(), set.rows.end(), [](const ContactRow& a, const ContactRow& b) {
      return a.time_fraction < b.time_fraction;
    });
    return {};
  }
  if (c.corrected != "negate") return mismatch(c, "corrected", "all rows can be sorted or negated only");
  for (ContactRow& row : set.rows) {
    const auto value = read_field(row, c.field);
    if (!value) return mismatch(c, "field", "has no column " + c.field);
    if (*value) write_field(row, c.field, 0.0 - **value);
  }
  return {};
}

Result<void> correct_field(ContactRow& row, const Correction& c) {
  const auto value = read_field(row, c.field);
  if (!value || !*value) return mismatch(c, "field", "has no " + c.field + " in that row");
  const auto printed = data::parse_number(c.printed, "corrections", c.line, "printed");
  if (!printed) return tl::unexpected(printed.error());
  if (**value != *printed) return mismatch(c, "printed", "is not what the data has");
  if (c.corrected == "exclude") {
    if (c.field != "rotation_fraction")
      return mismatch(c, "field", "only a rotation can be left out of a row");
    row.rotation_fraction.reset();
    return {};
  }
  const auto replacement = data::parse_number(c.corrected, "corrections", c.line, "corrected");
  if (!replacement) return tl::unexpected(replacement.error());
  write_field(row, c.field, *replacement);
  return {};
}

Result<void> apply(ContactSet& set, const Correction& c) {
  if (c.row == "all") return correct_all_rows(set, c);
  const auto time = data::parse_number(c.row, "corrections", c.line, "row");
  if (!time) return tl::unexpected(time.error());
  const auto same_time = [&time](const ContactRow& row) { return row.time_fraction == *time; };
  const auto row = std::find_if(set.rows.begin(), set.rows.end(), same_time);
  if (row == set.rows.end()) return mismatch(c, "row", "has no row at that time");
  if (c.field != "row") return correct_field(*row, c);
  if (c.corrected != "exclude") return mismatch(c, "corrected", "a row can be excluded only");
  set.rows.erase(row);
  return {};
}

}  // namespace

Result<ContactSet> corrected(ContactSet set, std::span<const Correction> corrections) {
  for (const Correction& c : corrections) {
    if (c.table != "contact" || c.set != set.name) continue;
    if (const auto done = apply(set, c); !done) return tl::unexpected(done.error());
  }
  return set;
}

}  // namespace strobe::thesis
