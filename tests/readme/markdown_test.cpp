#include "tests/readme/markdown.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::readme;

namespace {

const char* const kText =
    "Run `strobe fire\n--shots 3` or see [there](host/README.md).\n"
    "```sh\nmake all  # everything\nfire --shots \\\n  2 | wc\n```\n"
    "```sh not-run-in-tests: needs a rig\nstop\n```\n"
    "| `late_flash` | a flash |\n| `x`, `y` | two |\n";

}  // namespace

TEST_GROUP(Markdown){};

TEST(Markdown, BlocksHaveAnInfoStringATextAndALine) {
  const auto blocks = parse(kText).blocks;
  LONGS_EQUAL(2, blocks.size());
  CHECK_EQUAL("sh", blocks[0].info);
  LONGS_EQUAL(4, blocks[0].line);
  CHECK_EQUAL("sh not-run-in-tests: needs a rig", blocks[1].info);
  CHECK_EQUAL("stop\n", blocks[1].text);
}

TEST(Markdown, SpansAndLinksAreFoundOutsideBlocks) {
  const Markdown markdown = parse(kText);
  CHECK_EQUAL("strobe fire --shots 3", markdown.spans.at(0));
  LONGS_EQUAL(1, markdown.links.size());
  CHECK_EQUAL("host/README.md", markdown.links.at(0));
}

TEST(Markdown, CommandsLoseCommentsAndAreSplitAtPipes) {
  const auto commands = commands_of(parse(kText).blocks.at(0).text);
  LONGS_EQUAL(3, commands.size());
  CHECK_EQUAL("make all", commands[0]);
  LONGS_EQUAL(3, words_of(commands[1]).size());
  CHECK_EQUAL("wc", commands[2]);
}

TEST(Markdown, FirstCellsAreThoseWithOneCodeSpan) {
  const auto cells = first_cells(kText);
  LONGS_EQUAL(1, cells.size());
  CHECK_EQUAL("late_flash", cells[0]);
}
