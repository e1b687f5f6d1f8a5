#include <filesystem>

#include "tests/support/program_run.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::testing;
namespace fs = std::filesystem;

namespace {

CompletedProcess thesis(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {STROBE_PROGRAM, "thesis"});
  return run_program(std::move(arguments));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void check_drawn(const fs::path& folder) {
  int svg = 0, csv = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string content = read_text(entry.path());
    if (entry.path().extension() == ".svg") {
      ++svg;
      CHECK_TEXT(content.starts_with("<svg ") && content.ends_with("</svg>\n"), entry.path().c_str());
      CHECK_TEXT(contains(content, "Figure ") && contains(content, "<path "), entry.path().c_str());
    } else {
      ++csv;
      CHECK_TEXT(content.starts_with("series,x,y,low,high\n"), entry.path().c_str());
      CHECK_TEXT(content.size() > 1000, entry.path().c_str());
    }
  }
  LONGS_EQUAL(14, svg);
  LONGS_EQUAL(14, csv);
}

}  // namespace

TEST_GROUP(ThesisCommand){};

TEST(ThesisCommand, PrintsAllTables) {
  const CompletedProcess run = thesis({});
  LONGS_EQUAL(0, run.status->code);
  CHECK_EQUAL("", run.err);
  for (int table = 2; table <= 17; ++table)
    CHECK_TEXT(contains(run.out, "Table " + std::to_string(table) + ". "), std::to_string(table).c_str());
}

TEST(ThesisCommand, PrintsOneTableOfOneSetAsOneJsonObject) {
  const auto json = json_of(thesis({"--table", "8", "--set", "zero_68", "--json"}));
  const auto& distance = json["rows"][0]["dwell_distance_cm"];
  CHECK_EQUAL(0.16, distance["printed"]);
  CHECK_EQUAL(1.61, distance["computed"]);
  CHECK_EQUAL("misprint", distance["reason"]);
}

TEST(ThesisCommand, PrintsOneJsonObjectForEachTable) {
  const auto lines = jsons_of(thesis({"--json"}));
  CHECK(lines.size() >= 16);
  for (const auto& line : lines) CHECK(line.contains("table") && line.contains("rows"));
}

TEST(ThesisCommand, NamesTheTablesAndSetsThatThereAre) {
  const CompletedProcess run = thesis({"--table", "99"});
  LONGS_EQUAL(2, run.status->code);
  CHECK(contains(run.err, "strobe: thesis: no table 99; there are 2, 3, 4"));
  check_refused(thesis({"--set", "zero_24"}), "thesis: no set zero_24; the thesis has zero_17 to back_68");
  check_refused(thesis({"--all-sets"}), "thesis: --all-sets is for --figures; tables show all sets anyway");
}

TEST(ThesisCommand, RefusesATableThatHasNothingOfTheSet) {
  for (const char* form : {"--as-printed", "--json"})
    check_refused(thesis({"--table", "3", "--set", "zero_23", form}),
                  "thesis: table 3 has nothing of set zero_23");
  const CompletedProcess all = thesis({"--set", "zero_23"});
  LONGS_EQUAL(0, all.status->code);
  CHECK(contains(all.out, "Table 2. ") && !contains(all.out, "Table 3. "));
}

TEST(ThesisCommand, RefusesAnOptionLeftEmpty) {
  for (const std::string option : {"--table", "--set", "--figures"}) {
    const CompletedProcess run = thesis({option, ""});
    CHECK_EQUAL("strobe thesis: " + option + ": must not be empty (strobe thesis --help)\n", run.err);
    LONGS_EQUAL(2, run.status->code);
  }
}

TEST(ThesisCommand, DrawsFourteenFiguresOfTheThreeSpins) {
  const TemporaryFolder folder;
  const CompletedProcess run = thesis({"--figures", folder / "figures"});
  check_prints(run, {"14 figures in "});
  CHECK(contains(run.err, "figure 14 of 14"));
  check_drawn(folder / "figures");
}

TEST(ThesisCommand, DrawsOneSetIntoItsOwnFolderAndTellsTheFiles) {
  const TemporaryFolder folder;
  const auto lines = jsons_of(thesis({"--figures", folder.path().string(), "--set", "back_59", "--json"}));
  LONGS_EQUAL(14, lines.size());
  for (const auto& file : lines[13]["files"]) CHECK(fs::is_regular_file(file.get<std::string>()));
  check_drawn(folder / "back_59");
}

TEST(ThesisCommand, RefusesAFolderThatCannotBeMade) {
  const TemporaryFolder folder;
  write_text(folder / "file", "");
  const std::string inside = (folder / "file" / "figures").string();
  check_refused(thesis({"--figures", inside}), inside + ": cannot be made: Not a directory");
}

TEST(ThesisCommand, ExplainsItself) { check_prints(thesis({"--help"}), {"Examples:"}); }
