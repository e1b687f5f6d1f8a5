// Every table over the thesis's data: what is printed appears, and every difference has its reason.
#include <cmath>
#include <set>
#include <string>
#include <string_view>

#include "common/contact/condition_inputs.hpp"
#include "common/data/csv.hpp"
#include "host/thesis/thesis_inputs.hpp"
#include "host/thesis/table.hpp"
#include "host/thesis/tables.hpp"
#include "tests/host/thesis/loaded_thesis.hpp"
#include "tests/support/json_lines.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::thesis;
using strobe::testing::load_thesis;
using strobe::testing::loaded_thesis;
using thesis::Version;

namespace {

const std::vector<Table>& tables(Version version) {
  const auto make = [](Version v) {
    std::vector<Table> out;
    for (const TableEntry& entry : all_tables()) out.push_back(entry.make(loaded_thesis(v)));
    return out;
  };
  static const std::vector<Table> printed = make(Version::as_printed);
  static const std::vector<Table> corrected = make(Version::corrected);
  return version == Version::as_printed ? printed : corrected;
}

std::string where(const Table& table, const Row& row, std::size_t column) {
  return "table " + table.id + ", " + row.label + ", " + table.columns[column].key;
}

const Cell* cell_of(const Table& table, const std::string& label, const std::string& key) {
  for (const Row& row : table.rows)
    for (std::size_t i = 0; i < table.columns.size(); ++i)
      if (row.label == label && table.columns[i].key == key) return &row.cells[i];
  return nullptr;
}

/// The cell of Tables 2 to 10 that shows a column of a condition.
const Cell* mean_cell(const std::string& label, const std::string& key) {
  for (std::size_t i = 0; i < 9; ++i)
    if (const Cell* cell = cell_of(tables(Version::corrected)[i], label, key); cell && cell->printed)
      return cell;
  return nullptr;
}

const Table& table_of(std::string_view id) {
  for (const Table& table : tables(Version::corrected))
    if (table.id == id) return table;
  FAIL(std::string(id).c_str());
  return tables(Version::corrected).front();
}

}  // namespace

TEST_GROUP(ThesisTables){};

TEST(ThesisTables, AreAllThereWithDistinctIds) {
  std::set<std::string> seen;
  for (const TableEntry& entry : all_tables()) CHECK_TEXT(seen.insert(entry.id).second, entry.id.c_str());
  for (int number = 2; number <= 17; ++number) CHECK_EQUAL(1, seen.count(std::to_string(number)));
  for (const Table& table : tables(Version::corrected)) CHECK_TEXT(!table.rows.empty(), table.id.c_str());
}

TEST(ThesisTables, HaveACellForEveryColumnOfEveryRow) {
  for (const Version version : {Version::as_printed, Version::corrected})
    for (const Table& table : tables(version))
      for (const Row& row : table.rows)
        CHECK_EQUAL_TEXT(table.columns.size(), row.cells.size(), (table.id + " " + row.label).c_str());
}

TEST(ThesisTables, ExplainEveryDifference) {
  for (const Version version : {Version::as_printed, Version::corrected}) {
    for (const Table& table : tables(version)) {
      for (const Row& row : table.rows) {
        for (std::size_t i = 0; i < row.cells.size(); ++i) {
          const Cell& cell = row.cells[i];
          const std::string place = where(table, row, i);
          CHECK_TEXT(cell.reason != Reason::unexplained, place.c_str());
          const bool erratum = cell.reason == Reason::misprint || cell.reason == Reason::inconsistent;
          CHECK_TEXT(!erratum || !cell.remark.empty(), place.c_str());
          if (!cell.difference()) continue;
          CHECK_TEXT(cell.reason != Reason::none && cell.reason != Reason::as_measured, place.c_str());
          const bool small = cell.reason == Reason::agrees || cell.reason == Reason::rounding ||
                             cell.reason == Reason::mean_of_function;
          CHECK_TEXT(!small || std::abs(*cell.difference()) <= cell.allowed, place.c_str());
        }
      }
    }
  }
}

TEST(ThesisTables, ShowEveryPrintedMeanAndSdOfTables2To10) {
  const auto csv = strobe::testing::read_csv(std::string(STROBE_THESIS_FOLDER) + "/tables_02_to_10.csv");
  int shown = 0;
  for (const auto& row : csv.rows) {
    const std::string set = row[0] + "_" + row[1];
    for (std::size_t i = 5; i < csv.columns.size(); i += 2) {
      const Cell* cell = mean_cell(set, csv.columns[i]);
      CHECK_TEXT(cell != nullptr, (set + " " + csv.columns[i]).c_str());
      DOUBLES_EQUAL(std::stod(row[i]), *cell->printed, 0.0);
      DOUBLES_EQUAL(std::stod(row[i + 1]), *cell->printed_sd, 0.0);
      ++shown;
    }
  }
  LONGS_EQUAL(21 * 14, shown);
}

TEST(ThesisTables, ShowEveryOtherPrintedValueAtHand) {
  for (const thesis::PrintedValue& value : loaded_thesis(Version::corrected).values) {
    const Table& table = table_of(value.table == "freund" ? std::string_view("stiffness") : value.table);
    bool found = false;
    for (const Row& row : table.rows)
      for (const Cell& cell : row.cells)
        found = found || (row.label == value.set && cell.printed == value.value);
    CHECK_TEXT(found, (value.table + " " + value.set + " " + value.quantity).c_str());
  }
}

// The errata that were found by hand, each with what it must come to.
TEST(ThesisTables, FindTheKnownMisprints) {
  struct Known {
    const char* table;
    const char* set;
    const char* column;
    double computed;
  };
  for (const Known& k : {Known{"5", "zero_17", "v_lo_mps", 11.866},
                         {"2", "zero_23", "theta_in_deg", -23.247},
                         {"5", "zero_23", "theta_out_deg", 33.088},
                         {"8", "zero_68", "dwell_distance_cm", 1.61},
                         {"9", "top_18", "e", 0.876},
                         {"9", "top_71", "theta_in_deg", -70.91}}) {
    const Cell* cell = cell_of(table_of(k.table), k.set, k.column);
    CHECK(cell != nullptr);
    LONGS_EQUAL(static_cast<int>(Reason::misprint), static_cast<int>(cell->reason));
    DOUBLES_EQUAL(k.computed, *cell->computed, 0.0006);
  }
}

TEST(ThesisTables, WithoutCorrectionsComputeFromWhatIsPrinted) {
  const ThesisInputs& printed = loaded_thesis(Version::as_printed);
  const Table table = system_table(printed, 8, "zero");
  const Cell* distance = cell_of(table, "zero_68", "dwell_distance_cm");
  CHECK_FALSE(distance->computed.has_value());
  DOUBLES_EQUAL(0.16 / 3.9 * 10.0, *cell_of(table, "zero_68", "mean_speed_mps")->computed, 1e-12);
}

TEST(ThesisTables, OfOneSetHaveItsRowsOnly) {
  const ThesisInputs one = load_thesis(Version::corrected, "back_40");
  CHECK(incoming_table(one, 2, "zero").rows.empty());
  LONGS_EQUAL(1, incoming_table(one, 4, "back").rows.size());
  CHECK_EQUAL("back_40", see_table(one).rows.at(0).label);
  LONGS_EQUAL(3, cubic_table(one).rows.size());
  LONGS_EQUAL(1, rolling_table(one).rows.size());
}

TEST(ThesisTables, ForetellImagesThatLieOnThePulseByThePulse) {
  ThesisInputs one = load_thesis(Version::corrected, "top_34");
  const thesis::Condition& c = *one.used.condition("top_34");
  const contact::ContactScale scale = contact_scale(one, c);
  const auto pulse = contact::SpinPulse::make(contact::spin_pulse_input(c, impact::PulseForm::exact));
  for (data::ContactRow& row : one.used.contact.at("top_34").rows) {
    const auto at = contact::trajectory_of(*pulse)(row.time_fraction);
    row.x_fraction = at.x_m / scale.dwell_distance_m;
    row.y_fraction = at.y_m / scale.diameter_m;
    row.rotation_fraction = at.rotation_rad / scale.total_rotation_rad;
  }
  const Table table = cross_validation_table(one);
  LONGS_EQUAL(1, table.rows.size());
  for (const char* quantity : {"x_pulse_mm", "y_pulse_mm", "rotation_pulse_deg"})
    DOUBLES_EQUAL(0.0, *cell_of(table, "top_34", quantity)->computed, 1e-10);
  for (const char* quantity : {"x_cubic_mm", "y_cubic_mm", "y_spline_mm", "rotation_cubic_deg"})
    CHECK_TEXT(*cell_of(table, "top_34", quantity)->computed > 1e-3, quantity);
}

TEST(ThesisTables, ForetellImagesThatLieOnCubicsByTheCubics) {
  ThesisInputs one = load_thesis(Version::corrected, "top_34");
  for (data::ContactRow& row : one.used.contact.at("top_34").rows) {
    const double t = row.time_fraction;
    row.x_fraction = t * (1.5 + t * (-0.7 + 0.2 * t));
    row.y_fraction = -t * (1.0 - t) * (0.8 + 0.3 * t);
    row.rotation_fraction = t * t * (2.5 - 1.5 * t);
  }
  const Table table = cross_validation_table(one);
  for (const char* quantity : {"x_cubic_mm", "y_cubic_mm", "rotation_cubic_deg"})
    DOUBLES_EQUAL(0.0, *cell_of(table, "top_34", quantity)->computed, 1e-9);
  for (const char* quantity : {"x_pulse_mm", "y_pulse_mm", "rotation_pulse_deg"})
    CHECK_TEXT(*cell_of(table, "top_34", quantity)->computed > 0.1, quantity);
}

// The CSV files hold 270 images between touchdown and lift-off; the corrections leave out six of them.
TEST(ThesisTables, ForetellEveryImageOfEverySet) {
  const Table& table = table_of("cross_validation");
  LONGS_EQUAL(22, table.rows.size());
  DOUBLES_EQUAL(264.0, *cell_of(table, "all sets", "n")->computed, 0.0);
  for (const Row& row : table.rows)
    for (std::size_t i = 0; i < row.cells.size(); ++i)
      CHECK_TEXT(row.cells[i].computed > 0.0, where(table, row, i).c_str());
}

TEST(ThesisTables, RefuseASetThatTheThesisDoesNotHave) {
  const auto inputs = load_inputs(STROBE_THESIS_FOLDER, Version::corrected, "zero_24");
  CHECK_EQUAL("no set zero_24; the thesis has zero_17 to back_68", inputs.error().message);
}

TEST(ThesisTables, AreJsonAndTextThroughout) {
  for (const Table& table : tables(Version::corrected)) {
    const auto parsed = nlohmann::json::parse(json(table));
    CHECK_EQUAL_TEXT(table.rows.size(), parsed["rows"].size(), table.id.c_str());
    const std::string shown = text(table);
    CHECK_TEXT(shown.find("nan") == std::string::npos && shown.find("inf") == std::string::npos,
               table.id.c_str());
  }
}

TEST_GROUP(PrintedValues){};

TEST(PrintedValues, KeepTheUnitOfTheirLastDigit) {
  const auto values = thesis::parse_printed_values(
      "table,set,quantity,unit,value,provenance\n17,zero_23,see_x,mm,1.070,Table 17\n9,a,n,1,-12,there\n",
      "p.csv");
  CHECK(values.has_value());
  DOUBLES_EQUAL(1e-3, values->at(0).last_digit, 1e-18);
  DOUBLES_EQUAL(1.0, values->at(1).last_digit, 0.0);
  DOUBLES_EQUAL(1.07, thesis::find(*values, "17", "zero_23", "see_x")->value, 0.0);
  CHECK(thesis::find(*values, "17", "zero_23", "see_y") == nullptr);
}

TEST(PrintedValues, AreRefusedWithoutProvenanceOrNumber) {
  const std::string header = "table,set,quantity,unit,value,provenance\n";
  CHECK_EQUAL("p.csv:2: provenance: is missing",
              thesis::parse_printed_values(header + "17,zero_23,see_x,mm,1.070,\n", "p.csv").error().message);
  CHECK_EQUAL("p.csv:2: value: 'one' is not a number",
              thesis::parse_printed_values(header + "17,zero_23,see_x,mm,one,T\n", "p.csv").error().message);
  CHECK_EQUAL("/no/such/folder/printed_values.csv: No such file or directory",
              thesis::load_printed_values("/no/such/folder").error().message);
}
