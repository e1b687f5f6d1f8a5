#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "common/command_line/command_line.hpp"
#include "tests/support/string_from.hpp"

using strobe::command_line::for_experts;
using strobe::command_line::set_help;
using strobe::command_line::wrapped;

namespace {

constexpr std::size_t kColumns = 80;

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_GROUP(Wrapped){};

TEST(Wrapped, BreaksAtBlanksAndKeepsTheMargin) {
  CHECK_EQUAL("one two\nthree", wrapped("one two three", 8));
  CHECK_EQUAL("  one\n  two", wrapped("  one two", 6));
  CHECK_EQUAL("one\ntwo", wrapped("one\ntwo", 8));
}

TEST(Wrapped, KeepsWordsThatAreTooLong) { CHECK_EQUAL("a\nlonglonglong\nb", wrapped("a longlonglong b", 4)); }

TEST(Wrapped, KeepsCommandsToTypeWhole) {
  CHECK_EQUAL("Examples: rig fire --shots 3\n          rig fire --shots 4\nlater\non",
              wrapped("Examples: rig fire --shots 3\n          rig fire --shots 4\nlater on", 6));
}

TEST_GROUP(Help) {
  CLI::App app{"A program with a description that is longer than a line of eighty columns could ever hold."};
  double length_m = 0.5;
  int shots = 1;
  CLI::App* command = nullptr;

  void setup() override {
    app.name("rig");
    set_help(app);
    command = app.add_subcommand("fire", "Fires");
    command
        ->add_option("--shots", shots, "how many shots, in words that take more than one line of the screen")
        ->check(CLI::Range(1, 9))
        ->capture_default_str();
    command->add_option("--length", length_m, "of something");
    for_experts(*command, {"--length"});
    command->footer("For all.\fFor experts.");
  }
  std::string help() { return command->help("rig"); }
  std::string all() { return command->help("rig", CLI::AppFormatMode::All); }
};

TEST(Help, LeavesOutWhatIsForExperts) {
  CHECK(has(help(), "--shots N "));
  CHECK(has(help(), "For all."));
  CHECK_FALSE(has(help(), "--length"));
  CHECK_FALSE(has(help(), "For experts."));
}

TEST(Help, ShowsItAllOnRequestWithTheLimits) {
  CHECK(has(all(), "--length NUMBER"));
  CHECK(has(all(), "--shots N [1 - 9]"));
  CHECK(has(all(), "For experts."));
}

TEST(Help, NamesTheDefault) { CHECK(has(help(), "(default 1)")); }

TEST(Help, FitsEightyColumns) {
  for (const std::string& text : {help(), all(), app.help()}) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) CHECK_TEXT(line.size() <= kColumns, line.c_str());
  }
}

TEST(Help, RefusesToHideAnOptionThatIsNotThere) {
  CHECK_THROWS(CLI::OptionNotFound, for_experts(*command, {"--depth"}));
}

using strobe::command_line::complaint;

namespace {

/// What a program with two commands says of a command line; empty if it takes it.
std::string said_of(std::vector<std::string> words) {
  CLI::App app("A program.");
  app.name("rig");
  app.require_subcommand(1);
  int shots = 1;
  std::string image;
  CLI::App* fire = app.add_subcommand("fire");
  fire->add_option("--shots", shots)->check(CLI::Range(1, 9));
  app.add_subcommand("digitize")->add_option("IMAGE", image)->required();
  app.add_subcommand("hidden")->group("");
  std::reverse(words.begin(), words.end());
  try {
    app.parse(words);
  } catch (const CLI::ParseError& error) {
    return complaint(app, error);
  }
  return "";
}

}  // namespace

TEST_GROUP(Complaint){};

TEST(Complaint, SaysNothingOfARightCommandLine) { CHECK_EQUAL("", said_of({"fire", "--shots", "3"})); }

TEST(Complaint, SuggestsTheOptionAndNamesTheCommandsHelp) {
  CHECK_EQUAL("rig fire: no option --shot; did you mean --shots? (rig fire --help)",
              said_of({"fire", "--shot", "3"}));
  CHECK_EQUAL("rig fire: no option --shot; did you mean --shots? (rig fire --help)",
              said_of({"fire", "--shot=3"}));
  CHECK_EQUAL("rig fire: no option --colour (rig fire --help)", said_of({"fire", "--colour"}));
}

TEST(Complaint, TellsOfAMisspeltOptionBeforeWhatIsMissingForIt) {
  CHECK_EQUAL("rig digitize: no option --hlp; did you mean --help? (rig digitize --help)",
              said_of({"digitize", "--hlp"}));
}

TEST(Complaint, SuggestsTheCommand) {
  CHECK_EQUAL("rig: no command fyre; did you mean fire? (rig --help)", said_of({"fyre"}));
  CHECK_EQUAL("rig: no command dance (rig --help)", said_of({"dance"}));
  CHECK_EQUAL("rig: no command hiddn (rig --help)", said_of({"hiddn"}));
  CHECK_EQUAL("rig: which command? (rig --help)", said_of({}));
}

TEST(Complaint, SaysWhatIsWrongWithAValue) {
  CHECK_EQUAL("rig fire: --shots: Value 0 not in range 1 to 9 (rig fire --help)",
              said_of({"fire", "--shots", "0"}));
  CHECK_EQUAL("rig fire: --shots: its value is missing (rig fire --help)", said_of({"fire", "--shots"}));
  CHECK_EQUAL("rig digitize: IMAGE is required (rig digitize --help)", said_of({"digitize"}));
  CHECK_EQUAL("rig fire: \"3\" was not expected (rig fire --help)", said_of({"fire", "3"}));
}

TEST(Complaint, IsOneLineWhateverWasTyped) {
  const std::string said = said_of({"fire", "--a\nb\rc"});
  CHECK(said.find_first_of("\n\r") == std::string::npos);
}
