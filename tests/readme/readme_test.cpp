// The READMEs against the programs: what they tell a newcomer to type works as typed, and what they name exists.
#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/reduction/flags.hpp"
#include "common/reduction/readout.hpp"
#include "sim/scene/faults.hpp"
#include "tests/readme/markdown.hpp"
#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace strobe::readme;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;
namespace fs = std::filesystem;

namespace {

const fs::path kRoot = STROBE_SOURCE_DIR;
const fs::path kPrograms = fs::path(STROBE_BUILD_DIR) / "bin";

constexpr std::size_t kMaxWordsOfFrontPage = 1800;

/// More blocks that nothing runs are not accepted: find a way to run them.
constexpr int kMaxBlocksNotRun = 7;

bool runs(const Block& block) { return block.info == "sh"; }
bool is_marked(const Block& block) { return block.info.rfind("sh not-run-in-tests: ", 0) == 0; }

/// Guides, which are read like a README.
constexpr const char* kBench = "firmware/BENCH.md";
constexpr const char* kExperiment = "host/EXPERIMENT.md";
/// The host's README, and those of its folders that go on with its session.
const std::vector<std::string> kHost{
    "host/README.md",        "host/series/README.md", "host/report/README.md",     "host/digitize/README.md",
    "host/interlaboratory/README.md",
    "host/camera/README.md",
    "host/design/README.md", "host/export/README.md", "host/commission/README.md", "host/commands/README.md"};

/// All README.md of the tree and the guides, as paths from its root, the front page first.
std::vector<std::string> readmes() {
  std::vector<std::string> found{"README.md"};
  for (const char* folder : {"common", "firmware", "host", "sim", "tests"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder))
      if (entry.path().filename() == "README.md") found.push_back(fs::relative(entry.path(), kRoot).string());
  }
  found.insert(found.end(), {kBench, kExperiment});
  std::sort(found.begin() + 1, found.end());
  return found;
}

std::string text_of(const std::string& readme) { return strobe::testing::read_text(kRoot / readme); }

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  CHECK_TEXT(at != std::string::npos, from.c_str());
  return text.replace(at, from.size(), to);
}

/// A folder that looks like the repository after a build: links to its folders and programs. Its example rig file has more
/// patience than the shipped one, since a test may run on a busy machine: shots that are late are not aborted, and
/// photographs, which are rendered at the lowest priority, are waited for. Simulated rigs' own files have it anyway.
void imitate_repository(const fs::path& folder) {
  for (const char* name : {"README.md", "common", "host", "sim", "tests"})
    fs::create_symlink(kRoot / name, folder / name);
  fs::create_directories(folder / "build/release");
  fs::create_symlink(kPrograms, folder / "build/release/bin");
  for (const char* name : {"lib", "share"})
    fs::create_symlink(kPrograms.parent_path() / name, folder / "build/release" / name);
  fs::create_directory(folder / "firmware");
  std::string rig = strobe::testing::read_text(kRoot / "firmware/rig.toml");
  rig = replaced(rig, "\nabort_late_us = 1500 ", "\nabort_late_us = 1000000 ");
  rig = replaced(rig, "\nphotograph_timeout_s = 5\n", "\nphotograph_timeout_s = 120\n");
  strobe::testing::write_text(folder / "firmware/rig.toml", rig);
}

/// The blocks of READMEs as one script that stops at the first command that fails and says where.
std::string script_of(const std::vector<std::string>& names) {
  std::string script =
      "set -eo pipefail\n"
      "trap 'status=$?; set +e; trap - ERR; kill $(jobs -p); wait; exit $status' EXIT\n"
      "trap 'echo \"failed ($?): $BASH_COMMAND\" >&2' ERR\n";
  for (const std::string& readme : names)
    for (const Block& block : parse(text_of(readme)).blocks)
      if (runs(block)) script += fmt::format("echo '-- {}:{}' >&2\n{}", readme, block.line, block.text);
  return script;
}

std::string tail(const std::string& text, std::size_t length) {
  return text.size() <= length ? text : "..." + text.substr(text.size() - length);
}

/// Output of `PROGRAM [SUBCOMMAND] --help-all`, or --help where a program has no other; empty if there is no such program or subcommand.
const std::string& help_of(const std::string& program, const std::string& subcommand) {
  static std::map<std::pair<std::string, std::string>, std::string> known;
  const auto [entry, is_new] = known.try_emplace({program, subcommand});
  if (!is_new) return entry->second;
  strobe::testing::Command command{{kPrograms / program}, {}, {}, {}};
  if (!subcommand.empty()) command.arguments.push_back(subcommand);
  for (const char* option : {"--help-all", "--help"}) {
    command.arguments.push_back(option);
    const auto finished = strobe::testing::run_process(command, 20s);
    if (finished.status == ExitStatus({0, 0})) return entry->second = finished.out;
    command.arguments.pop_back();
  }
  return entry->second;
}

bool is_subcommand(const std::string& word) {
  return !word.empty() && word.front() != '-' &&
         std::all_of(word.begin(), word.end(), [](char c) { return std::islower(c) != 0 || c == '-'; });
}

/// What a command names that its program's help does not.
std::vector<std::string> unknown_names(const std::string& command) {
  static const std::set<std::string> programs{"strobe",       "strobed",         "strobe-sim",
                                              "strobe-bench", "strobe-campaign", "strobe-contradictions",
                                              "strobe-score", "strobe-soak"};
  static const std::regex option("--[a-z][a-z-]*");
  const std::vector<std::string> words = words_of(command);
  if (words.empty() || programs.count(words[0]) == 0) return {};
  if (!fs::exists(kPrograms / words[0])) {  // studies are built on request
    std::printf("not built, so not compared with its help: %s\n", command.c_str());
    return {};
  }
  const bool has_subcommands =
      words[0] != "strobed" && words[0] != "strobe-score" && words[0] != "strobe-soak";
  const std::string subcommand =
      has_subcommands && words.size() > 1 && is_subcommand(words[1]) ? words[1] : "";
  const std::string& help = help_of(words[0], subcommand);
  if (help.empty()) return {words[0] + " " + subcommand};
  std::vector<std::string> unknown;
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    std::smatch match;
    if (!std::regex_search(words[i], match, option, std::regex_constants::match_continuous)) continue;
    const std::regex whole(match.str() + "(?![a-z-])");
    if (!std::regex_search(help, whole)) unknown.push_back(words[0] + " " + subcommand + " " + match.str());
  }
  return unknown;
}

/// How many of the table's shots count, each of which must stand there once.
int counted_rows(const fs::path& results) {
  static const std::regex begin("[^,]*,([0-9a-f]+,[0-9]+),(.?)");  // utc, boot_id, shot_id, rejected
  std::set<std::string> shots;
  int counted = 0;
  std::istringstream rows(strobe::testing::read_text(results));
  std::string row;
  std::getline(rows, row);
  while (std::getline(rows, row)) {
    std::smatch cells;
    CHECK_TEXT(std::regex_search(row, cells, begin, std::regex_constants::match_continuous), row.c_str());
    CHECK_TEXT(shots.insert(cells[1]).second, row.c_str());
    if (cells[2] == ",") ++counted;
  }
  return counted;
}

/// Runs the blocks of READMEs in order, in a folder that looks like a built clone.
void check_commands(const std::vector<std::string>& names,
                    const strobe::testing::TemporaryFolder& clone = {}) {
  imitate_repository(clone.path());
  const auto finished =
      strobe::testing::run_process({{"bash", "-c", script_of(names)}, {}, clone.path(), {}}, 900s);
  CHECK_TEXT(finished.status == ExitStatus({0, 0}),
             (names.front() + "\n" + tail(finished.err, 4000)).c_str());
}

}  // namespace

TEST_GROUP(Readme){};

TEST(Readme, CommandsOfTheFrontPageWorkAsTyped) { check_commands({"README.md"}); }

TEST(Readme, CommandsOfTheHostWorkAsTyped) { check_commands(kHost); }

TEST(Readme, CommandsOfTheGuideToTheBenchWorkAsTyped) { check_commands({kBench}); }

TEST(Readme, CommandsOfAllOthersWorkAsTyped) {
  for (const std::string& readme : readmes())
    if (readme != "README.md" && std::ranges::count(kHost, readme) == 0 && readme != kBench &&
        readme != kExperiment)
      check_commands({readme});
}

// Interrupted, gone on with and corrected: no shot is missing from the table or stands in it twice.
TEST(Readme, TheGuideToAnExperimentWorksAsTyped) {
  const strobe::testing::TemporaryFolder clone;
  check_commands({kExperiment}, clone);
  const fs::path folder = clone.path() / "sessions" / "experiment";
  LONGS_EQUAL(10, counted_rows(folder / "hard" / "results.csv"));
  LONGS_EQUAL(5, counted_rows(folder / "soft" / "results.csv"));
  STRCMP_CONTAINS(",corrected,3,", strobe::testing::read_text(folder / "hard" / "results.csv").c_str());
  const std::string report = strobe::testing::read_text(folder / "hard.html");
  STRCMP_CONTAINS("Example laboratory", report.c_str());
  STRCMP_CONTAINS("A. Author", report.c_str());
}

TEST(Readme, TheGuidesPinsAreThoseOfTheRaspberryPisRigFiles) {
  static const std::regex row("\\| `([a-z_]+)` \\| ([0-9]+) \\| ([0-9]+) \\|");
  const std::string guide = text_of(kBench);
  int lines = 0;
  for (std::sregex_iterator cells(guide.begin(), guide.end(), row), end; cells != end; ++cells, ++lines) {
    const std::regex wired(fmt::format("{} *= \\{{ line = {}\\b.*# pin {}\\b", (*cells)[1].str(),
                                       (*cells)[2].str(), (*cells)[3].str()));
    for (const char* board : {"raspberry-pi-3", "raspberry-pi-4", "raspberry-pi-5"})
      CHECK_TEXT(std::regex_search(text_of(fmt::format("firmware/boards/{}.toml", board)), wired),
                 (*cells)[0].str().c_str());
  }
  CHECK_EQUAL(9, lines);
}

TEST(Readme, TheGuidesLinesMakeARigFileThatStrobedAndTheHostTake) {
  const strobe::testing::TemporaryFolder folder;
  std::string wiring;
  for (const Block& block : parse(text_of(kBench)).blocks)
    if (block.info == "toml") wiring += block.text;
  CHECK(wiring.find("[lines]") != std::string::npos);
  const std::string example = text_of("firmware/rig.toml");
  const std::size_t chip = example.find("[chip]\n"), lamps = example.find("[lamps]\n");
  strobe::testing::write_text(folder / "rig.toml",
                              example.substr(0, chip) + wiring + "\n" + example.substr(lamps));
  // Read through; then there is no such chip here.
  const auto started = strobe::testing::run_process({{kPrograms / "strobed", "--config", folder / "rig.toml",
                                                      "--session", folder / "session", "--allow-no-rt"},
                                                     {},
                                                     folder.path(),
                                                     {}},
                                                    20s);
  STRCMP_CONTAINS("chip.name: ", started.err.c_str());
  const auto key = strobe::testing::run_process({{kPrograms / "strobe", "key", "--rig", folder / "rig.toml"},
                                                 {{"HOME", folder.path()}},
                                                 folder.path(),
                                                 {}},
                                                20s);
  CHECK_TEXT(key.status == ExitStatus({0, 0}), key.err.c_str());
}

TEST(Readme, TheDemoFiresItsShots) {
  const strobe::testing::TemporaryFolder clone;
  imitate_repository(clone.path());
  // Built already, and in a network of its own.
  const auto finished = strobe::testing::run_process(
      {{clone / "sim/demo", "--shots", "2"}, {{"STROBE_DEMO_INSIDE", "1"}}, clone.path(), {}}, 300s);
  CHECK_TEXT(finished.status == ExitStatus({0, 0}), tail(finished.out + finished.err, 4000).c_str());
}

TEST(Readme, BlocksThatNothingRunsAreFewAndSayWhy) {
  int not_run = 0;
  for (const std::string& readme : readmes()) {
    for (const Block& block : parse(text_of(readme)).blocks) {
      const std::string place = fmt::format("{}:{}: ```{}", readme, block.line - 1, block.info);
      CHECK_TEXT(block.info.empty() || block.info == "toml" || runs(block) || is_marked(block),
                 place.c_str());
      if (!is_marked(block)) continue;
      ++not_run;
      std::printf("not run: %s\n", place.c_str());
    }
  }
  CHECK(not_run <= kMaxBlocksNotRun);
}

TEST(Readme, NamesOnlyProgramsSubcommandsAndOptionsThatExist) {
  std::string unknown;
  for (const std::string& readme : readmes()) {
    const Markdown markdown = parse(text_of(readme));
    std::vector<std::string> texts = markdown.spans;
    for (const Block& block : markdown.blocks)
      if (block.info.rfind("sh", 0) == 0) texts.push_back(block.text);
    for (const std::string& text : texts) {
      for (const std::string& command : commands_of(text))
        for (const std::string& name : unknown_names(command)) unknown += readme + ": " + name + "\n";
    }
  }
  CHECK_EQUAL("", unknown);
}

TEST(Readme, LinksLeadSomewhere) {
  for (const std::string& readme : readmes()) {
    for (const std::string& link : parse(text_of(readme)).links) {
      if (link.find("://") != std::string::npos) continue;
      const fs::path target = (kRoot / readme).parent_path() / link.substr(0, link.find('#'));
      CHECK_TEXT(fs::exists(target), (readme + ": " + link).c_str());
    }
  }
}

TEST(Readme, TheFrontPageIsShort) { CHECK(words_of(text_of("README.md")).size() <= kMaxWordsOfFrontPage); }

TEST(Readme, TheFrontPageSaysWhatEachPackageIsFor) {
  const std::vector<std::string> words =
      words_of(std::regex_replace(text_of("README.md"), std::regex(","), " "));
  std::istringstream packages(strobe::testing::read_text(kRoot / "tests/packages.txt"));
  for (std::string line; std::getline(packages, line);) {
    const std::vector<std::string> entry = words_of(line);  // what for, name, its command
    if (entry.size() < 2 || entry[0] == "#") continue;
    const auto names_it = [&](const std::string& word) {
      return fnmatch(word.c_str(), entry[1].c_str(), 0) == 0;
    };
    CHECK_TEXT(std::any_of(words.begin(), words.end(), names_it), entry[1].c_str());
  }
}

TEST(Readme, EveryFlagOfAReadoutIsDescribed) {
  const std::vector<std::string> cells = first_cells(text_of("common/reduction/README.md"));
  const std::set<std::string> described(cells.begin(), cells.end());
  for (const std::string_view flag : strobe::reduction::kFlagNames)
    CHECK_TEXT(described.count(std::string(flag)) == 1, std::string(flag).c_str());
}

TEST(Readme, EveryFaultOfASceneIsDescribed) {
  const std::vector<std::string> cells = first_cells(text_of("sim/README.md"));
  for (const std::string_view fault : strobe::sim::kFaultNames)
    CHECK_TEXT(std::ranges::count(cells, fault) == 1, std::string(fault).c_str());
}

TEST(Readme, EveryQuantityOfAReadoutIsDescribed) {
  const std::string text = text_of("common/reduction/README.md");
  for (const std::string_view quantity : strobe::reduction::kQuantityNames)
    CHECK_TEXT(text.find(fmt::format("`{}`", quantity)) != std::string::npos, std::string(quantity).c_str());
}
