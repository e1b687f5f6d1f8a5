// What the project's READMEs contain besides words: fenced blocks, code spans, links and tables. Reads text that is
// already in memory; throws nothing; thread-safe.
#pragma once

#include <string>
#include <vector>

namespace strobe::readme {

/// A fenced block. Its info string is what follows the opening fence: "sh", or "sh not-run-in-tests: why".
struct Block {
  std::string info;
  std::string text;  ///< with line ends, without the fences
  int line = 0;      ///< 1-based, of the first line of the text
};

struct Markdown {
  std::vector<Block> blocks;
  std::vector<std::string> spans;  ///< texts between single back quotes, outside blocks
  std::vector<std::string> links;  ///< targets of [words](target) and ![words](target), outside blocks
};

Markdown parse(const std::string& text);

/// First cells of the rows of tables whose first cell is one code span, without the back quotes.
std::vector<std::string> first_cells(const std::string& text);

/// Commands of a block or span: comments removed, lines that end with a backslash joined, split at |, && and ;.
/// Quoting is not understood beyond what the READMEs use.
std::vector<std::string> commands_of(const std::string& text);

/// Words separated by blanks.
std::vector<std::string> words_of(const std::string& text);

}  // namespace strobe::readme
