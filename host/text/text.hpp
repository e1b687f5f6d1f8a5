// Text for a terminal, without escape codes; widths by fmt, which unlike wcwidth() needs no locale. No I/O;
// thread-safe.
#pragma once

#include <charconv>
#include <string>
#include <string_view>
#include <vector>

namespace strobe::host {

/// Number of characters (UTF-8 code points).
std::size_t columns(std::string_view text);

/// Cut to at most width columns; a cut text ends in "…". Control characters become spaces.
std::string cut(std::string_view text, std::size_t width);

/// Padded with spaces to the width on the right (left-aligned) or on the left; cut if it is longer.
std::string left(std::string_view text, std::size_t width);
std::string right(std::string_view text, std::size_t width);

/// Lines of at most `width` columns, broken at spaces; a longer word has a line of its own. Lines after the
/// first begin with `indent`.
std::vector<std::string> wrapped(std::string_view text, std::size_t width, std::string_view indent = "  ");

/// The value with as many decimals as its uncertainty has significance (two digits of the sd), at least
/// `least` and at most 6.
std::string rounded(double value, double sd, int least = 0);

/// Takes the word off the text's beginning. False: it does not begin so, and stays as it is.
inline bool take(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return false;
  text.remove_prefix(word.size());
  return true;
}

/// Likewise a whole number in this base.
template <typename Number>
bool take(std::string_view& text, Number& number, int base) {
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number, base);
  if (read.ec != std::errc()) return false;
  text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
  return true;
}

// Widths that the tables of shots and series have in common. Pure; thread-safe.

inline constexpr std::size_t kNameWidth = 17;
inline constexpr std::size_t kUnitWidth = 6;
inline constexpr std::size_t kNumberWidth = 10;

/// Each line cut to the width, without spaces at its end.
inline std::vector<std::string> fitted(std::vector<std::string> lines, std::size_t width) {
  for (std::string& line : lines) {
    line = cut(line, width);
    while (!line.empty() && line.back() == ' ') line.pop_back();
  }
  return lines;
}

}  // namespace strobe::host
