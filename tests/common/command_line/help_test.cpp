#include "common/command_line/help.hpp"

#include <CLI/CLI.hpp>
#include <sstream>
#include <string>

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
