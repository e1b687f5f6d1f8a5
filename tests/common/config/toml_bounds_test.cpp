// TOML that is looked at before it is parsed: what would take the parser's stack is refused, all of ours is not.
#include "common/config/toml_bounds.hpp"

#include <string>

#include "common/config/default_rig.hpp"
#include "common/config/files.hpp"
#include "common/config/toml_reader.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::config;

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

std::string problem(const std::string& text) {
  const auto found = toml_bounds_problem(text);
  return found ? found->message : "";
}

std::string error(const std::string& text) {
  TomlReader reader(text, "f.toml");
  reader.root().accept_all();
  const auto found = reader.error();
  return found ? found->message : "";
}

}  // namespace

TEST_GROUP(TomlBounds){};

TEST(TomlBounds, ADottedKeyAsLongAsTheFileIsNotParsed) {
  CHECK_EQUAL("f.toml:1: a key of more than 16 parts", error(repeated("a.", 120'000) + "a = 1\n"));
  CHECK_EQUAL("f.toml:2: a key of more than 16 parts", error("b = 1\n[" + repeated("a.", 120'000) + "a]\n"));
  CHECK_EQUAL("f.toml:1: a key of more than 16 parts", error(repeated("\"a,\" .\t", 60'000) + "a = 1\n"));
  CHECK_EQUAL("f.toml:1: a key of more than 16 parts", error("x = {" + repeated("''.", 60'000) + "a = 1}\n"));
}

TEST(TomlBounds, BracketsWithinBracketsAreNotParsed) {
  CHECK_EQUAL("f.toml:1: more than 16 brackets within each other", error("x = " + repeated("[", 100'000)));
  CHECK_EQUAL("f.toml:2: more than 16 brackets within each other",
              error("y = 1\nx = " + repeated("{a=[", 50'000)));
}

TEST(TomlBounds, CharactersBeyondAsciiStandInQuotesAndCommentsOnly) {
  const std::string stray = "a character beyond ASCII stands neither in quotes nor in a comment";
  CHECK_EQUAL("f.toml:2: " + stray, error("a = 1\np\u00E9riode = 3\n"));
  CHECK_EQUAL("f.toml:1: " + stray, error("a = 3\u3000\n"));
  CHECK_EQUAL("", error("a = \"\u00E9\\n\" # \u00E9\nb = '\\\u00E9'\nc = \"\"\"\u00E9\n\u00E9\"\"\"\n"));
  CHECK_EQUAL("", error("\xEF\xBB\xBF# a file of an editor that marks UTF-8\na = 1\n"));
}

TEST(TomlBounds, NoCharacterBeyondAsciiStandsBehindABackslashWhereTheParserLooksForBlanks) {
  const std::string stray = "a character beyond ASCII stands behind a backslash";
  CHECK_EQUAL("f.toml:1: " + stray, error("a = \"\"\"x\\\u00E9\"\"\"\n"));
  CHECK_EQUAL("f.toml:2: " + stray, error("a = \"\"\"\nx\\ \n \u00E9\"\"\"\n"));
  CHECK_EQUAL("", error("a = \"\"\"x\\ \n y\u00E9\"\"\"\n"));
}

TEST(TomlBounds, ALongTextIsNotParsed) {
  CHECK_EQUAL("f.toml:1: larger than 1 MB",
              error(std::string(kMaxToml_bytes + 1, '\n')));
  CHECK_EQUAL("", error(std::string(kMaxToml_bytes, '\n')));
}

TEST(TomlBounds, WhatTextsAndCommentsHoldDoesNotCount) {
  const std::string dots = repeated("a.[{", 500);
  CHECK_EQUAL("", error("x = \"" + dots + "\\\"" + dots + "\" # " + dots + "\ny = '" + dots + "\\'\n"));
  CHECK_EQUAL("", error("x = \"\"\"\n" + dots + "\n\\\"\"\" \"\" " + dots + "\"\"\"\"\"\ny = 1\n"));
  CHECK_EQUAL("", error("x = '''" + dots + "\n'' " + dots + "\\''''\ny = ''\nz = \"\"\n"));
  CHECK_EQUAL("",
              error(repeated("a = [1.5, 2.5, [3.5]]\n", 1) + "[b]\nc.d = {e.f = 2026-01-31T09:30:00.5Z}\n"));
}

TEST(TomlBounds, WhatIsWithinThemMayBeAsDeepAsTheyLet) {
  const std::string key = repeated("a.", kMaxKeyParts - 1) + "a";
  std::string value = "1";
  for (int i = 0; i < kMaxOpenBrackets; ++i) value = "{" + key + " = " + value + "}";
  CHECK_EQUAL("", error("[[" + key + "]]\n" + key + " = " + value + "\n"));
}

TEST(TomlBounds, OfTextThatIsNoTomlAnythingMayBeAsked) {
  for (const char* text : {"", "\"", "'''", "\"\"\"", "\"\\", "]]]]}}}", "a.", "#", "\\", "\"\n", "'\n"})
    CHECK_EQUAL("", problem(text));
}

TEST(TomlBounds, TheExampleRigIsWithinThem) {
  CHECK_EQUAL("", problem(read_file(rig_file_or_example("", "--rig").value()).value()));
}
