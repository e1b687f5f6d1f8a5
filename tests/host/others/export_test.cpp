// strobe export: what stands in a log, as tables and as JSON.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/host/others/stored_example.hpp"
#include "tests/support/program_run.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using others::StoredExample;

namespace {

testing::CompletedProcess export_log(std::vector<std::string> words) {
  words.insert(words.begin(), {STROBE_BUILD_DIR "/bin/strobe", "export"});
  return testing::run_program(std::move(words));
}

}  // namespace

TEST_GROUP(Export) {
  StoredExample stored;
  std::string tables = (stored.folder / "tables").string();
};

TEST(Export, WritesATableForEachKindOfMessageAndEachOfItsLists) {
  const auto run = export_log({stored.folder.path(), "--out", tables});
  LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  CHECK_EQUAL(tables + "/event.csv: 3 rows\n" + tables + "/shot.csv: 1 rows\n" + tables +
                  "/shot.flashes.csv: 2 rows\n",
              run.out);
  const auto flashes = testing::read_csv(tables + "/shot.flashes.csv");
  LONGS_EQUAL(2, flashes.rows.size());
  const auto cell = [&](std::size_t row, const char* name) {
    return flashes.rows[row][flashes.column(name)];
  };
  CHECK_EQUAL("host-20260131T093000Z.lcmlog", cell(0, "log"));
  CHECK_EQUAL("4", cell(0, "record"));
  CHECK_EQUAL("0", cell(0, "flashes_index"));
  CHECK_EQUAL("1000004000", cell(0, "observed_a_ns"));
  CHECK_EQUAL("", cell(0, "observed_b_ns"));  // none was seen
  CHECK_EQUAL("1003005000", cell(1, "observed_b_ns"));
  const auto shots = testing::read_csv(tables + "/shot.csv");
  CHECK_EQUAL("3000000", shots.rows[0][shots.column("plan.period_ns")]);
  CHECK_EQUAL("7f00000000000001", shots.rows[0][shots.column("boot_id")]);
  CHECK_EQUAL(stored.key.fingerprint(), shots.rows[0][shots.column("sealed_by")]);
}

TEST(Export, DescribesEachColumn) {
  CHECK_EQUAL(0, export_log({stored.log(), "--out", tables}).status->code);
  const auto metadata = nlohmann::json::parse(testing::read_text(tables + "/shot.flashes.csv-metadata.json"));
  const auto& columns = metadata["tableSchema"]["columns"];
  const auto named = testing::read_csv(tables + "/shot.flashes.csv").columns;
  LONGS_EQUAL(named.size(), columns.size());
  for (std::size_t i = 0; i < named.size(); ++i) CHECK_EQUAL(named[i], columns[i]["name"].get<std::string>());
  CHECK_EQUAL(
      "ns", columns.back()["name"] == "extra_edges" ? columns[5]["schema:unitCode"].get<std::string>() : "");
}

TEST(Export, QuotesTextsThatWouldBreakATable) {
  const auto run = export_log({stored.log(), "--table", "event"});
  check_prints(run, {",\"a, \"\"b\"\"\n=1+1\"\n"});
}

TEST(Export, PrintsMessagesAsJsonWithIdentifiersAsTexts) {
  const auto lines =
      jsons_of(export_log({stored.log(), "--channel", "SHOT", "--json", "--key-file", stored.key_file}));
  LONGS_EQUAL(1, lines.size());
  CHECK_EQUAL("SHOT", lines[0]["kind"].get<std::string>());
  CHECK_TRUE(lines[0]["verified"].get<bool>());
  const auto& shot = lines[0]["message"];
  CHECK_EQUAL("7f00000000000001", shot["boot_id"].get<std::string>());
  LONGS_EQUAL(2, shot["flashes"].size());
  CHECK_TRUE(shot["flashes"][0]["observed_b_ns"].is_null());
  LONGS_EQUAL(3'000'000, shot["plan"]["period_ns"].get<int>());
}

TEST(Export, GivesAllElseOfADamagedLogAndTellsWhere) {
  std::string log = testing::read_text(stored.log());
  log.insert(0, "damage");
  testing::write_text(stored.log(), log + "torn");
  const auto run = export_log({stored.log(), "--channel", "EVENT", "--json"});
  LONGS_EQUAL(1, run.status->code);
  LONGS_EQUAL(3, testing::parse_json_lines(run.out).size());
  CHECK_EQUAL("strobe: " + stored.log().string() + ": damaged: 10 bytes are no record, the first at 0\n",
              run.err);
}

TEST(Export, RefusesWhatIsNoLog) {
  const std::string results = (stored.folder / "results.csv").string();
  LONGS_EQUAL(2, export_log({results, "--json"}).status->code);
  check_refused(export_log({stored.folder / "none", "--json"}),
                (stored.folder / "none").string() + ": no such file or folder");
  check_refused(export_log({stored.log()}), "export: give one of --out, --table and --json");
}
