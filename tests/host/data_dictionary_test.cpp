#include "host/session/data_dictionary.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/reduction/readout.hpp"
#include "host/config/notes.hpp"
#include "host/session/flashes_csv.hpp"
#include "host/session/results_csv.hpp"
#include "host/session/session_folder.hpp"
#include "host/view/quantities.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::Column;

const Column& column(const std::vector<Column>& columns, const std::string& name) {
  const auto found = std::ranges::find(columns, name, &Column::name);
  CHECK_TRUE_TEXT(found != columns.end(), name.c_str());
  return *found;
}

/// What stands behind the last `_` that begins a unit: "_mps" of "vx_td_mps".
std::string unit_by_name(const std::string& name) {
  for (const auto& [ending, unit] : {std::pair{"_mps", "m/s"},
                                     {"_radps", "rad/s"},
                                     {"_deg", "deg"},
                                     {"_ms", "ms"},
                                     {"_cm", "cm"},
                                     {"_m", "m"},
                                     {"_c", "Cel"},
                                     {"_ns", "ns"}}) {
    if (name.ends_with(ending)) return unit;
  }
  return {};
}

std::string names_of(const nlohmann::json& metadata) {
  std::string names;
  for (const auto& described : metadata["tableSchema"]["columns"])
    names += (names.empty() ? "" : ",") + described["name"].get<std::string>();
  return names;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

nlohmann::json json_in(const std::filesystem::path& file) {
  return nlohmann::json::parse(testing::read_text(file));
}

}  // namespace

TEST_GROUP(DataDictionary){};

TEST(DataDictionary, SaysOfEveryColumnWhatItIsAndOfEveryNumberItsUnit) {
  for (const auto* columns : {&host::results_columns(), &host::flashes_columns()}) {
    std::set<std::string> names;
    for (const Column& c : *columns) {
      CHECK_TRUE_TEXT(names.insert(c.name).second, c.name.c_str());
      CHECK_TRUE_TEXT(c.meaning.size() >= 4, c.name.c_str());
      if (c.datatype == "number") CHECK_TRUE_TEXT(!c.unit.empty(), c.name.c_str());
      const std::string unit = unit_by_name(c.name);
      if (!unit.empty()) CHECK_EQUAL_TEXT(unit, c.unit, c.name.c_str());
    }
  }
}

TEST(DataDictionary, HasTheUnitsThatTheScreenShows) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const std::string unit(host::kQuantityLabels[i].unit);
    for (const char* prefix : {"", "sd_", "sd_systematic_"}) {
      const Column c = column(host::results_columns(), prefix + std::string(reduction::kQuantityNames[i]));
      CHECK_EQUAL_TEXT(unit.empty() ? "1" : unit, c.unit, c.name.c_str());
    }
  }
}

TEST(DataDictionary, NamesAllNotesThatHaveAColumn) {
  for (const std::string_view note : host::kNamedNotes) column(host::results_columns(), std::string(note));
}

TEST(DataDictionary, LiesBesideTheTablesOfASessionAndHasTheirColumns) {
  testing::TemporaryFolder folder;
  CHECK_TRUE(host::SessionFolder::open(folder.path(), "20260131T093000Z", "", "").has_value());
  for (const char* table : {"results.csv", "flashes.csv"}) {
    const auto metadata = json_in(folder / (std::string(table) + "-metadata.json"));
    CHECK_EQUAL("http://www.w3.org/ns/csvw", metadata["@context"].get<std::string>());
    CHECK_EQUAL(std::string(table), metadata["url"].get<std::string>());
    CHECK_EQUAL(first_line(testing::read_text(folder / table)), names_of(metadata));
  }
}

TEST(DataDictionary, HasTheColumnsOfATableThatAnEarlierVersionBegan) {
  testing::TemporaryFolder folder;
  testing::write_text(folder / "results.csv", host::earlier_results_headers().back() + "\n");
  testing::write_text(folder / "results.csv-metadata.json", "{}");
  CHECK_TRUE(host::SessionFolder::open(folder.path(), "20260131T093000Z", "", "").has_value());
  CHECK_EQUAL(host::earlier_results_headers().back(),
              names_of(json_in(folder / "results.csv-metadata.json")));
}
