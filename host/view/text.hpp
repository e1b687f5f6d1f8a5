// Text for a terminal, without escape codes; widths by fmt, which unlike wcwidth() needs no locale. No I/O;
// thread-safe.
#pragma once

#include <string>
#include <string_view>

namespace strobe::host {

/// Number of characters (UTF-8 code points).
std::size_t columns(std::string_view text);

/// Cut to at most width columns; a cut text ends in "…". Control characters become spaces.
std::string cut(std::string_view text, std::size_t width);

/// Padded with spaces to the width on the right (left-aligned) or on the left; cut if it is longer.
std::string left(std::string_view text, std::size_t width);
std::string right(std::string_view text, std::size_t width);

/// The value with as many decimals as its uncertainty has significance (two digits of the sd), at least
/// `least` and at most 6.
std::string rounded(double value, double sd, int least = 0);

}  // namespace strobe::host
