#include "tests/readme/markdown.hpp"

#include <algorithm>
#include <regex>
#include <sstream>

namespace strobe::readme {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> all_matches(const std::string& text, const std::regex& pattern) {
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match)
    found.push_back((*match)[1]);
  return found;
}

}  // namespace

Markdown parse(const std::string& text) {
  static const std::regex span("`([^`]+)`");
  static const std::regex link(R"(\]\(([^)\s]+)\))");
  Markdown markdown;
  std::string prose;
  bool in_block = false;
  int number = 0;
  for (const std::string& line : lines_of(text)) {
    ++number;
    if (line.rfind("```", 0) == 0) {
      in_block = !in_block;
      if (in_block) markdown.blocks.push_back({line.substr(3), "", number + 1});
    } else {
      (in_block ? markdown.blocks.back().text : prose) += line + '\n';
    }
  }
  // A span or the words of a link may go on in the next line.
  std::replace(prose.begin(), prose.end(), '\n', ' ');
  markdown.spans = all_matches(prose, span);
  markdown.links = all_matches(std::regex_replace(prose, span, ""), link);
  return markdown;
}

std::vector<std::string> first_cells(const std::string& text) {
  static const std::regex row(R"(\| `([^`]+)` \|)");
  std::vector<std::string> cells;
  for (const std::string& line : lines_of(text)) {
    std::smatch match;
    if (std::regex_search(line, match, row, std::regex_constants::match_continuous))
      cells.push_back(match[1]);
  }
  return cells;
}

std::vector<std::string> commands_of(const std::string& text) {
  static const std::regex comment("(^|\\s)#[^\\n]*");
  static const std::regex continued("\\\\\\n");
  static const std::regex separator(R"(\s*(\n|\||&&|;|&)\s*)");
  const std::string joined = std::regex_replace(std::regex_replace(text, comment, "$1"), continued, " ");
  std::vector<std::string> commands;
  for (std::sregex_token_iterator part(joined.begin(), joined.end(), separator, -1), end; part != end; ++part)
    if (!words_of(*part).empty()) commands.push_back(*part);
  return commands;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace strobe::readme
