// The command thesis as a user runs it.
#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/json_lines.hpp"
#include "tests/support/process.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

using strobe::testing::CompletedProcess;
using strobe::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

CompletedProcess thesis(std::vector<std::string> arguments,
                        const std::map<std::string, std::string>& environment = {}) {
  arguments.insert(arguments.begin(), {STROBE_PROGRAM, "thesis"});
  return strobe::testing::run_process(
      {.arguments = std::move(arguments), .environment = environment, .folder = {}},
      std::chrono::seconds(100));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

void check_complaint(int status, const CompletedProcess& run, const std::string& expected) {
  LONGS_EQUAL(status, run.status->code);
  STRCMP_EQUAL("", run.out.c_str());
  STRCMP_EQUAL(expected.c_str(), run.err.c_str());
}

void check_drawn(const fs::path& folder) {
  int svg = 0;
  int png = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string content = strobe::testing::read_text(entry.path());
    CHECK_TEXT(!content.empty(), entry.path().c_str());
    if (entry.path().extension() == ".svg") {
      ++svg;
      CHECK_TEXT(content.rfind("<?xml", 0) == 0 && contains(content, "</svg>"), entry.path().c_str());
      CHECK_TEXT(contains(content, "Figure "), entry.path().c_str());
    }
    if (entry.path().extension() == ".png") {
      ++png;
      CHECK_TEXT(content.rfind("\x89PNG\r\n", 0) == 0 && contains(content, "IEND"), entry.path().c_str());
      CHECK_TEXT(content.size() > 10000, entry.path().c_str());  // an empty page is smaller
    }
  }
  LONGS_EQUAL(14, svg);
  LONGS_EQUAL(14, png);
}

}  // namespace

TEST_GROUP(ThesisCommand){};

TEST(ThesisCommand, PrintsAllTables) {
  const CompletedProcess run = thesis({});
  LONGS_EQUAL(0, run.status->code);
  STRCMP_EQUAL("", run.err.c_str());
  for (int table = 2; table <= 17; ++table)
    CHECK_TEXT(contains(run.out, "Table " + std::to_string(table) + ". "), std::to_string(table).c_str());
}

TEST(ThesisCommand, PrintsOneTableOfOneSetAsOneJsonObject) {
  const CompletedProcess run = thesis({"--table", "8", "--set", "zero_68", "--json"});
  LONGS_EQUAL(0, run.status->code);
  const auto lines = strobe::testing::parse_json_lines(run.out);
  LONGS_EQUAL(1, lines.size());
  const auto& distance = lines[0]["rows"][0]["dwell_distance_cm"];
  DOUBLES_EQUAL(0.16, distance["printed"].get<double>(), 0.0);
  DOUBLES_EQUAL(1.61, distance["computed"].get<double>(), 0.0);
  STRCMP_EQUAL("misprint", distance["reason"].get<std::string>().c_str());
}

TEST(ThesisCommand, PrintsOneJsonObjectForEachTable) {
  const CompletedProcess run = thesis({"--json"});
  const auto lines = strobe::testing::parse_json_lines(run.out);
  CHECK(lines.size() >= 16);
  for (const auto& line : lines) CHECK(line.contains("table") && line.contains("rows"));
}

TEST(ThesisCommand, NamesTheTablesAndSetsThatThereAre) {
  const CompletedProcess run = thesis({"--table", "99"});
  LONGS_EQUAL(2, run.status->code);
  CHECK(contains(run.err, "strobe: thesis: no table 99; there are 2, 3, 4"));
  check_complaint(2, thesis({"--set", "zero_24"}),
                  "strobe: thesis: no set zero_24; the thesis has zero_17 to back_68\n");
  check_complaint(2, thesis({"--all-sets"}),
                  "strobe: thesis: --all-sets is for --figures; tables show all sets anyway\n");
}

TEST(ThesisCommand, RefusesATableThatHasNothingOfTheSet) {
  for (const char* form : {"--as-printed", "--json"})
    check_complaint(2, thesis({"--table", "3", "--set", "zero_23", form}),
                    "strobe: thesis: table 3 has nothing of set zero_23\n");
  const CompletedProcess all = thesis({"--set", "zero_23"});
  LONGS_EQUAL(0, all.status->code);
  CHECK(contains(all.out, "Table 2. ") && !contains(all.out, "Table 3. "));
}

TEST(ThesisCommand, RefusesAnOptionLeftEmpty) {
  for (const char* option : {"--table", "--set", "--figures"})
    check_complaint(2, thesis({option, ""}),
                    "strobe: " + std::string(option) +
                        ": must not be empty (strobe --help lists commands and options)\n");
}

TEST(ThesisCommand, DrawsFourteenFiguresOfTheThreeSpins) {
  const TemporaryFolder folder;
  const CompletedProcess run = thesis({"--figures", (folder / "figures").string()});
  LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  CHECK(contains(run.out, "14 figures in "));
  CHECK(contains(run.err, "figure 14 of 14"));
  check_drawn(folder / "figures");
}

TEST(ThesisCommand, DrawsOneSetIntoItsOwnFolderAndTellsTheFiles) {
  const TemporaryFolder folder;
  const CompletedProcess run = thesis({"--figures", folder.path().string(), "--set", "back_59", "--json"});
  LONGS_EQUAL_TEXT(0, run.status->code, run.err.c_str());
  const auto lines = strobe::testing::parse_json_lines(run.out);
  LONGS_EQUAL(14, lines.size());
  for (const auto& file : lines[13]["files"]) CHECK(fs::is_regular_file(file.get<std::string>()));
  check_drawn(folder / "back_59");
}

TEST(ThesisCommand, RefusesAFolderThatCannotBeMade) {
  const TemporaryFolder folder;
  strobe::testing::write_text(folder / "file", "");
  const std::string inside = (folder / "file" / "figures").string();
  check_complaint(2, thesis({"--figures", inside}),
                  "strobe: " + inside + ": cannot be made: Not a directory\n");
}

TEST(ThesisCommand, NamesThePackageWhereGnuplotIsMissing) {
  const TemporaryFolder folder;
  check_complaint(1, thesis({"--figures", folder.path().string()}, {{"PATH", folder.path().string()}}),
                  "strobe: figures need gnuplot, which is not installed: apt-get install gnuplot-nox\n");
}

TEST(ThesisCommand, ExplainsItself) {
  const CompletedProcess run = thesis({"--help"});
  LONGS_EQUAL(0, run.status->code);
  CHECK(contains(run.out, "Examples:"));
}
