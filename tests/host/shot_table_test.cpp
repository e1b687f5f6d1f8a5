#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/reduction/readout.hpp"
#include "host/config/notes.hpp"
#include "host/session/record_file.hpp"
#include "host/session/session_folder.hpp"
#include "host/session/shot_table.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::CsvFile;
using host::Shot;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

/// Fields of one CSV line (RFC 4180 quoting).
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> result{""};
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      result.back() += line[i++];
    else if (line[i] == '"')
      quoted = !quoted;
    else if (line[i] == ',' && !quoted)
      result.emplace_back();
    else
      result.back() += line[i];
  return result;
}

std::string field(const Shot& shot_result, const std::string& column) {
  const auto names = fields(host::results_header());
  const auto values = fields(host::results_line(shot_result));
  LONGS_EQUAL(names.size(), values.size());
  const auto at = std::find(names.begin(), names.end(), column);
  CHECK_TRUE_TEXT(at != names.end(), column.c_str());
  return values[static_cast<std::size_t>(at - names.begin())];
}

Shot example() {
  Shot shot_result;
  shot_result.boot_id = 0x2a;
  shot_result.shot_id = 3;
  shot_result.name = "3";
  shot_result.utc = "2026-01-31T09:30:00.000Z";
  shot_result.digitizations.emplace_back().frame.source = "auto";
  shot_result.readout.value[reduction::Quantity::e] = 0.1;
  shot_result.readout.sd[reduction::Quantity::e] = 0.002;
  shot_result.readout.method = "best";
  shot_result.readout.flags.set(reduction::Flag::late_flash);
  shot_result.readout.flags.set(reduction::Flag::sensor_missing);
  shot_result.readout.record = {{"remarks", "wet, \"fast\""}, {"angle_deg", "23"}, {"string_tension", "25"}};
  shot_result.readout.flashes = reduction::ImagedFlashes{25, 37, 0.001, true};
  shot_result.rejected = "late";
  return shot_result;
}

/// Cells of a shot that tells nothing of it: value, sd and sd_systematic of each number.
const std::string kNoThirdDimension(3 * reduction::kSpatialCount, ',');

}  // namespace

TEST_GROUP(ResultsTable){};

TEST(ResultsTable, ALineHasAFieldForEachColumn) {
  const Shot shot_result = example();
  CHECK_EQUAL("2a", field(shot_result, "boot_id"));
  CHECK_EQUAL("3", field(shot_result, "shot_id"));
  CHECK_EQUAL("late", field(shot_result, "rejected"));
  CHECK_EQUAL("0.1", field(shot_result, "e"));
  CHECK_EQUAL("0.002", field(shot_result, "sd_e"));
  CHECK_EQUAL("", field(shot_result, "sd_systematic_e"));
  CHECK_EQUAL("", field(shot_result, "mu"));
  CHECK_EQUAL("late_flash;sensor_missing", field(shot_result, "flags"));
  CHECK_EQUAL("wet, \"fast\"", field(shot_result, "remarks"));
  CHECK_EQUAL("23", field(shot_result, "angle_deg"));
  CHECK_EQUAL("string_tension=25", field(shot_result, "other_notes"));
  CHECK_EQUAL("25", field(shot_result, "first_flash"));
  CHECK_EQUAL("37", field(shot_result, "last_flash"));
  CHECK_EQUAL("0.001", field(shot_result, "misassignment_probability"));
  CHECK_EQUAL("", field(Shot{}, "misassignment_probability"));
}

TEST(ResultsTable, TheThirdDimensionStandsBehindTheColumnsOfBefore) {
  Shot shot = example();
  CHECK_EQUAL("", field(shot, "vz_td_mps"));
  shot.readout.spatial.emplace()[reduction::SpatialQuantity::vz_td_mps] = {0.5, 0.25, 0.125};
  CHECK_EQUAL("0.5", field(shot, "vz_td_mps"));
  CHECK_EQUAL("0.25", field(shot, "sd_vz_td_mps"));
  CHECK_EQUAL("0.125", field(shot, "sd_systematic_vz_td_mps"));
  CHECK_EQUAL("", field(shot, "vz_lo_mps"));
  const auto names = fields(host::results_header());
  const auto behind = std::find(names.begin(), names.end(), "shot") + 1;
  CHECK_EQUAL("omega_x_td_radps", *behind);
  LONGS_EQUAL(3 * reduction::kSpatialCount, names.end() - behind);
}

TEST(ResultsTable, ASecondRunAppendsWithoutASecondHeader) {
  TemporaryFolder folder;
  for (const char* line : {"one", "two"}) {
    auto csv = CsvFile::open(folder / "results.csv", host::results_header());
    CHECK_TRUE(csv.has_value());
    CHECK_TRUE(csv->append(line).has_value());
  }
  CHECK_EQUAL(host::results_header() + "\none\ntwo\n", read_text(folder / "results.csv"));
}

TEST(ResultsTable, ALineThatWasCutShortIsRemovedAndOneWithAllColumnsIsClosed) {
  TemporaryFolder folder;
  for (const char* last : {"4,\"x,y", "4,5", "4", "1,2,3\n4,\"5,6\""}) {
    write_text(folder / "table.csv", "a,b,c\n1,2,3\n" + std::string(last));
    CHECK_TRUE(CsvFile::open(folder / "table.csv", "a,b,c")->append("7,8,9").has_value());
    const std::string whole = last[0] == '1' ? "1,2,3\n" : "";
    CHECK_EQUAL("a,b,c\n1,2,3\n" + whole + "7,8,9\n", read_text(folder / "table.csv"));
  }
  write_text(folder / "table.csv", "a,b,c\n1,\"2,\",3");  // as an editor may leave it
  CHECK_TRUE(CsvFile::open(folder / "table.csv", "a,b,c")->append("7,8,9").has_value());
  CHECK_EQUAL("a,b,c\n1,\"2,\",3\n7,8,9\n", read_text(folder / "table.csv"));
}

TEST(ResultsTable, AHeaderThatWasCutShortIsWrittenAnew) {
  TemporaryFolder folder;
  for (const char* header : {"", "a,", "a,b", "a,b,c"}) {
    write_text(folder / "table.csv", header);
    CHECK_TRUE(CsvFile::open(folder / "table.csv", "a,b,c")->append("7,8,9").has_value());
    CHECK_EQUAL("a,b,c\n7,8,9\n", read_text(folder / "table.csv"));
  }
}

TEST(ResultsTable, ATableOfAnEarlierVersionGoesOnWithItsColumns) {
  TemporaryFolder folder;
  const auto earlier = host::earlier_results_headers();
  const std::vector<std::string> without{kNoThirdDimension, ",auto,3" + kNoThirdDimension,
                                         ",25,37,0.001,auto,3" + kNoThirdDimension};
  LONGS_EQUAL(without.size(), earlier.size());
  const std::string line = host::results_line(example());
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    write_text(folder / "results.csv", earlier[i] + "\n");
    auto csv = CsvFile::open(folder / "results.csv", host::results_header(), earlier);
    CHECK_TRUE(csv.has_value());
    CHECK_TRUE(csv->append(line).has_value());
    const std::string shorter = line.substr(0, line.size() - without[i].size());
    CHECK_EQUAL(earlier[i] + "\n" + shorter + "\n", read_text(folder / "results.csv"));
    LONGS_EQUAL(fields(earlier[i]).size(), fields(shorter).size());
  }
}

TEST(ResultsTable, NamesAShotOfALaterStartOfTheFirmwareByItsStart) {
  TemporaryFolder folder;
  Shot shot = example();
  shot.digitizations.clear();
  for (const std::int64_t boot : {std::int64_t{0x2a}, std::int64_t{0x1234567800000001}}) {
    auto csv = host::ResultsCsv::open(folder / "results.csv");  // each in a run of its own
    shot.boot_id = boot;
    CHECK_TRUE(csv->add(shot).has_value());
    shot.digitizations.emplace_back().frame.source = "hand";
  }
  const auto rows = host::parse_results(read_text(folder / "results.csv"));
  LONGS_EQUAL(2, rows.size());
  LONGS_EQUAL(0x1234567800000001, rows[1].key.boot_id);
  CHECK_EQUAL("2026-01-31T09:30:00.000Z", rows[1].utc);
  CHECK_TRUE(rows[0].line.ends_with(",,3" + kNoThirdDimension));
  CHECK_TRUE(rows[1].line.ends_with(",hand,3/123456" + kNoThirdDimension));
}

TEST(ResultsTable, AnotherVersionsColumnsAreNotMixed) {
  TemporaryFolder folder;
  write_text(folder / "results.csv", "a,b,c\n1,2,3\n");
  const auto csv = CsvFile::open(folder / "results.csv", host::results_header());
  CHECK_FALSE(csv.has_value());
  STRCMP_CONTAINS("results.csv:1: another version's columns", csv.error().message.c_str());
}

TEST(ResultsTable, AFolderThatIsNotThereIsNamed) {
  STRCMP_CONTAINS("/nowhere/results.csv: cannot be written: No such file",
                  CsvFile::open("/nowhere/results.csv", host::results_header()).error().message.c_str());
}

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
