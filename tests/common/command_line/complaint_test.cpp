#include "common/command_line/complaint.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "tests/support/string_from.hpp"

using strobe::command_line::complaint;
using strobe::command_line::nearest;

namespace {

const std::vector<std::string> kNames{"--shots", "--session", "--spin", "--photographs", "--px-per-m"};

std::string nearest_of(const std::string& typed) { return nearest(typed, kNames).value_or("nothing"); }

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

TEST_GROUP(Nearest){};

TEST(Nearest, FindsALetterLeftOutAddedChangedOrSwapped) {
  CHECK_EQUAL("--shots", nearest_of("--shot"));
  CHECK_EQUAL("--shots", nearest_of("--shotss"));
  CHECK_EQUAL("--shots", nearest_of("--shits"));
  CHECK_EQUAL("--spin", nearest_of("--sipn"));
}

TEST(Nearest, FindsWhatWasBegun) { CHECK_EQUAL("--photographs", nearest_of("--photo")); }

TEST(Nearest, ForgivesCapitalsAndDashes) {
  CHECK_EQUAL("--shots", nearest_of("-SHOTS"));
  CHECK_EQUAL("--px-per-m", nearest_of("--px-per-m=4000"));
}

TEST(Nearest, DoesNotGuessWhereNothingIsNear) {
  CHECK_EQUAL("nothing", nearest_of("--colour"));
  CHECK_EQUAL("nothing", nearest_of("--"));
  CHECK_EQUAL("nothing", nearest_of(""));
  CHECK_FALSE(nearest("a", {"b"}).has_value());
}

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
