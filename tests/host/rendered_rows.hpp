// Finding a row in rendered lines.
#pragma once

#include <string>
#include <vector>

namespace strobe::testing {

/// The line that starts with the words, with runs of spaces as one; empty if there is none.
inline std::string row(const std::vector<std::string>& lines, const std::string& words) {
  for (const std::string& line : lines) {
    if (!line.starts_with(words)) continue;
    std::string text;
    for (const char c : line)
      if (c != ' ' || (!text.empty() && text.back() != ' ')) text += c;
    return text;
  }
  return "";
}

}  // namespace strobe::testing
