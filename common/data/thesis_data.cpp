#include "common/data/thesis_data.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/config/files.hpp"
#include "common/data/csv.hpp"

namespace strobe::thesis {

namespace {

constexpr std::array<std::string_view, 7> kCorrectionColumns{"set",     "table",     "row",   "field",
                                                             "printed", "corrected", "reason"};

constexpr std::array<std::string_view, 5> kLeadingColumns{"spin", "angle_label_deg", "n_incoming",
                                                          "n_rebound", "n_system"};

struct Field {
  std::string_view column;
  std::string_view sd_column;
  MeanSd Condition::*member;
};

constexpr std::array<Field, 14> kFields{{
    {"theta_in_deg", "theta_in_sd_deg", &Condition::theta_in_deg},
    {"vx_td_mps", "vx_td_sd_mps", &Condition::vx_td_mps},
    {"vy_td_mps", "vy_td_sd_mps", &Condition::vy_td_mps},
    {"v_td_mps", "v_td_sd_mps", &Condition::v_td_mps},
    {"omega_td_radps", "omega_td_sd_radps", &Condition::omega_td_radps},
    {"theta_out_deg", "theta_out_sd_deg", &Condition::theta_out_deg},
    {"vx_lo_mps", "vx_lo_sd_mps", &Condition::vx_lo_mps},
    {"vy_lo_mps", "vy_lo_sd_mps", &Condition::vy_lo_mps},
    {"v_lo_mps", "v_lo_sd_mps", &Condition::v_lo_mps},
    {"omega_lo_radps", "omega_lo_sd_radps", &Condition::omega_lo_radps},
    {"e", "e_sd", &Condition::e},
    {"mu", "mu_sd", &Condition::mu},
    {"dwell_distance_cm", "dwell_distance_sd_cm", &Condition::dwell_distance_cm},
    {"dwell_time_ms", "dwell_time_sd_ms", &Condition::dwell_time_ms},
}};

std::vector<std::string_view> condition_columns() {
  std::vector<std::string_view> columns(kLeadingColumns.begin(), kLeadingColumns.end());
  for (const Field& field : kFields) {
    columns.push_back(field.column);
    columns.push_back(field.sd_column);
  }
  return columns;
}

Result<Condition> parse_condition(const data::CsvRow& row, std::span<const std::string_view> columns,
                                  std::string_view source) {
  std::array<double, kLeadingColumns.size() + 2 * kFields.size()> values{};
  for (std::size_t i = 1; i < values.size(); ++i) {
    const auto value = data::parse_number(row.cells[i], source, row.line, columns[i]);
    if (!value) return tl::unexpected(value.error());
    const bool whole = *value == std::floor(*value) && *value >= 0.0 && *value < 1000.0;
    if (i < kLeadingColumns.size() && !whole)
      return data::csv_error(source, row.line, columns[i], "must be a whole number below 1000");
    values[i] = *value;
  }
  Condition c;
  c.spin = row.cells[0];
  if (c.spin != "zero" && c.spin != "top" && c.spin != "back")
    return data::csv_error(source, row.line, columns[0], "must be zero, top or back");
  c.angle_label_deg = static_cast<int>(values[1]);
  c.n_incoming = static_cast<int>(values[2]);
  c.n_rebound = static_cast<int>(values[3]);
  c.n_system = static_cast<int>(values[4]);
  for (std::size_t i = 0; i < kFields.size(); ++i) {
    const std::size_t column = kLeadingColumns.size() + 2 * i;
    c.*kFields[i].member = {values[column], values[column + 1]};
  }
  return c;
}

double* find_number(Condition& condition, std::string_view column) {
  for (const Field& field : kFields) {
    if (column == field.column) return &(condition.*field.member).mean;
    if (column == field.sd_column) return &(condition.*field.member).sd;
  }
  return nullptr;
}

Result<data::ContactSet> load_contact(const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path path = folder / "contact" / (name + ".csv");
  const auto text = config::read_file(path.string());
  if (!text) return tl::unexpected(text.error());
  auto set = data::parse_contact_csv(*text, path.string());
  if (set) set->name = name;
  return set;
}

}  // namespace

const Condition* Data::condition(std::string_view name) const {
  for (const Condition& c : conditions)
    if (c.name() == name) return &c;
  return nullptr;
}

Result<std::vector<Correction>> parse_corrections(std::string_view text, std::string_view source) {
  const auto rows = data::parse_csv(text, source, kCorrectionColumns);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<Correction> corrections;
  for (const data::CsvRow& row : *rows) {
    const auto cell = [&row](std::size_t i) { return std::string(row.cells[i]); };
    corrections.push_back({cell(0), cell(1), cell(2), cell(3), cell(4), cell(5), cell(6), row.line});
    for (const std::size_t required : {0U, 1U, 3U, 5U, 6U})
      if (row.cells[required].empty())
        return data::csv_error(source, row.line, kCorrectionColumns[required], "is missing");
  }
  return corrections;
}

Result<std::vector<Condition>> parse_conditions(std::string_view text, std::string_view source) {
  const std::vector<std::string_view> columns = condition_columns();
  const auto rows = data::parse_csv(text, source, columns);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<Condition> conditions;
  for (const data::CsvRow& row : *rows) {
    const auto condition = parse_condition(row, columns, source);
    if (!condition) return tl::unexpected(condition.error());
    conditions.push_back(*condition);
  }
  return conditions;
}

Result<std::vector<Condition>> corrected(std::vector<Condition> conditions,
                                         std::span<const Correction> corrections) {
  for (const Correction& c : corrections) {
    if (c.table != "tables_02_to_10") continue;
    double* number = nullptr;
    for (Condition& condition : conditions)
      if (condition.name() == c.set) number = find_number(condition, c.field);
    if (!number)
      return data::csv_error("corrections", c.line, "field", c.set + " has no number named " + c.field);
    const auto printed = data::parse_number(c.printed, "corrections", c.line, "printed");
    if (!printed) return tl::unexpected(printed.error());
    const auto value = data::parse_number(c.corrected, "corrections", c.line, "corrected");
    if (!value) return tl::unexpected(value.error());
    if (*number != *printed)
      return data::csv_error("corrections", c.line, "printed", "is not what the data has");
    *number = *value;
  }
  return conditions;
}

std::optional<Condition> shipped_condition(const std::string& spin, double angle_deg) {
  const auto share = config::share_folder();
  if (!share) return std::nullopt;
  const auto text = config::read_file((*share / "thesis" / "tables_02_to_10.csv").string());
  if (!text) return std::nullopt;
  const auto conditions = parse_conditions(*text, "tables_02_to_10.csv");
  if (!conditions) return std::nullopt;
  for (const Condition& condition : *conditions)
    if (condition.spin == spin && condition.angle_label_deg == std::abs(angle_deg)) return condition;
  return std::nullopt;
}

Result<Data> load(const std::filesystem::path& folder, Version version) {
  const auto corrections_text = config::read_file((folder / "corrections.csv").string());
  if (!corrections_text) return tl::unexpected(corrections_text.error());
  const auto tables_text = config::read_file((folder / "tables_02_to_10.csv").string());
  if (!tables_text) return tl::unexpected(tables_text.error());
  auto corrections = parse_corrections(*corrections_text, (folder / "corrections.csv").string());
  if (!corrections) return tl::unexpected(corrections.error());
  auto conditions = parse_conditions(*tables_text, (folder / "tables_02_to_10.csv").string());
  if (conditions && version == Version::corrected)
    conditions = corrected(*std::move(conditions), *corrections);
  if (!conditions) return tl::unexpected(conditions.error());

  Data data{.conditions = *std::move(conditions), .contact = {}, .corrections = *std::move(corrections)};
  for (const Condition& condition : data.conditions) {
    auto set = load_contact(folder, condition.name());
    if (set && version == Version::corrected) set = corrected(*std::move(set), data.corrections);
    if (!set) return tl::unexpected(set.error());
    data.contact.emplace(condition.name(), *std::move(set));
  }
  return data;
}

// Corrections of one contact set.

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
  const auto text = config::read_file(path.string());
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
