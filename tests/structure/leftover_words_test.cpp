// Nothing half-done and nothing of one person's machine stays in the sources.
#include <fmt/format.h>

#include <string>
#include <vector>

#include "tests/structure/source_tree.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe::structure;

// Written in halves, so that this file does not find itself.
const std::vector<std::string> kLeftovers{
    "TO"
    "DO",
    "FIX"
    "ME",
    "XX"
    "X:",
    "HA"
    "CK:",
    "/ho"
    "me/",
    "/ro"
    "ot/",
    "/Us"
    "ers/",
    "/wo"
    "rk/"};

bool part_of_a_longer_path(const std::string& line, std::size_t at, const std::string& word) {
  if (word[0] != '/' || at == 0) return false;
  const char before = line[at - 1];
  return before == '.' || before == '/' || std::isalnum(static_cast<unsigned char>(before)) != 0 ||
         before == '_' || before == '}';
}

}  // namespace

TEST_GROUP(LeftoverWords){};

TEST(LeftoverWords, NoneInTheSources) {
  std::string found;
  for (const SourceFile& file : source_files()) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      for (const std::string& word : kLeftovers) {
        const std::size_t at = file.lines[i].find(word);
        if (at == std::string::npos || part_of_a_longer_path(file.lines[i], at, word)) continue;
        found += fmt::format("\n  {}:{}: {}", file.path, i + 1, word);
      }
    }
  }
  CHECK_EQUAL("", found);
}

TEST(LeftoverWords, NoConflictMarkersOrTrailingBlanks) {
  std::string found;
  for (const SourceFile& file : cpp_files()) {
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      const std::string& line = file.lines[i];
      const bool conflict = starts_with(line,
                                        "<<<<<"
                                        "<< ") ||
                            starts_with(line,
                                        ">>>>>"
                                        ">> ");
      const bool blank = !line.empty() && (line.back() == ' ' || line.back() == '\t' || line.back() == '\r');
      if (conflict || blank) found += fmt::format("\n  {}:{}", file.path, i + 1);
    }
  }
  CHECK_EQUAL("", found);
}
