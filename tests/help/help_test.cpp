// Every command of every program: help that fits a screen, has an example and leaves nothing out on request; and what
// is misspelt is answered with what was meant.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/process.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace std::chrono_literals;
using strobe::testing::CompletedProcess;
using strobe::testing::ExitStatus;

constexpr std::size_t kLines = 40, kColumns = 80;

using Words = std::vector<std::string>;

CompletedProcess result_of(const Words& words) {
  strobe::testing::Command command;
  command.arguments = words;
  command.arguments[0] = std::string(STROBE_BUILD_DIR) + "/bin/" + words[0];
  return strobe::testing::run_process(command, 20s);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

Words with(Words words, const std::string& last) {
  words.push_back(last);
  return words;
}

std::string help_of(const Words& command, const std::string& option = "--help") {
  const CompletedProcess finished = result_of(with(command, option));
  CHECK_TEXT(finished.status == ExitStatus({0, 0}), fmt::format("{}", fmt::join(command, " ")).c_str());
  CHECK_EQUAL("", finished.err);
  return finished.out;
}

/// The programs, and the commands that their help lists.
std::vector<Words> commands() {
  std::vector<Words> all;
  for (const char* program : {"strobe", "strobed", "strobe-sim"}) {
    all.push_back({program});
    bool listed = false;
    static const std::regex entry("  ([a-z-]+) +[A-Z].*");
    for (const std::string& line : lines_of(help_of({program}))) {
      std::smatch match;
      if (line == "Commands:") listed = true;
      if (listed && std::regex_match(line, match, entry)) all.push_back({program, match[1]});
    }
  }
  return all;
}

std::set<std::string> options_in(const std::string& help) {
  static const std::regex option("(^|\n)  (-[a-z],)?(--[a-z0-9-]+)");
  std::set<std::string> found;
  for (std::sregex_iterator match(help.begin(), help.end(), option), end; match != end; ++match)
    found.insert((*match)[3]);
  return found;
}

}  // namespace

TEST_GROUP(EveryCommandsHelp){};

TEST(EveryCommandsHelp, CommandsAreFound) {
  const std::vector<Words> all = commands();
  for (const Words& known : {Words{"strobe", "fire"}, Words{"strobe", "key"}, Words{"strobe-sim", "run"},
                             Words{"strobe-sim", "effects"}, Words{"strobed"}})
    CHECK_TEXT(std::find(all.begin(), all.end(), known) != all.end(), known.back().c_str());
}

TEST(EveryCommandsHelp, FitsAScreen) {
  std::string wrong;
  for (const Words& command : commands()) {
    const std::vector<std::string> lines = lines_of(help_of(command));
    const std::string name = fmt::format("{}", fmt::join(command, " "));
    if (lines.size() > kLines) wrong += fmt::format("\n{}: {} lines", name, lines.size());
    bool example = false;
    for (const std::string& line : lines) {
      example = line.starts_with("Example") || (example && line.starts_with(" "));
      if (!example && line.size() > kColumns) wrong += fmt::format("\n{}: {}", name, line);
    }
  }
  CHECK_EQUAL("", wrong);
}

TEST(EveryCommandsHelp, HasAnExampleOfThatCommand) {
  for (const Words& command : commands()) {
    const std::string help = help_of(command), name = fmt::format("{}", fmt::join(command, " "));
    const std::size_t at = help.find("Example");
    CHECK_TEXT(at != std::string::npos && help.find(name + " ", at) != std::string::npos, name.c_str());
  }
}

TEST(EveryCommandsHelp, ShowsAllOptionsOnRequest) {
  for (const Words& command : commands()) {
    const std::set<std::string> few = options_in(help_of(command)),
                                all = options_in(help_of(command, "--help-all"));
    CHECK_TEXT(std::includes(all.begin(), all.end(), few.begin(), few.end()), command.back().c_str());
  }
  CHECK_EQUAL(0u, options_in(help_of({"strobe", "fire"})).count("--key-file"));
  CHECK_EQUAL(1u, options_in(help_of({"strobe", "fire"}, "--help-all")).count("--key-file"));
}

TEST(EveryCommandsHelp, IsNamedWithWhatWasMeantByAMisspeltOption) {
  for (const Words& command : commands()) {
    const std::string name = fmt::format("{}", fmt::join(command, " "));
    for (const std::string& option : options_in(help_of(command, "--help-all"))) {
      const std::string typed = option + "z";
      if (option.size() < std::string("--abcd").size()) continue;  // shorter ones are alike
      const CompletedProcess finished = result_of(with(command, typed));
      CHECK_TEXT(finished.status == ExitStatus({2, 0}), finished.err.c_str());
      CHECK_EQUAL(fmt::format("{}: no option {}; did you mean {}? ({} --help)\n", name, typed, option, name),
                  finished.err);
    }
  }
}

TEST(EveryCommandsHelp, IsNamedWithWhatWasMeantByAMisspeltCommand) {
  for (const Words& command : commands()) {
    if (command.size() < 2) continue;
    const CompletedProcess finished = result_of({command[0], command[1] + "z"});
    CHECK_EQUAL(ExitStatus({2, 0}), finished.status);
    CHECK_EQUAL(fmt::format("{0}: no command {1}z; did you mean {1}? ({0} --help)\n", command[0], command[1]),
                finished.err);
  }
}
