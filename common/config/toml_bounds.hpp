// What a TOML text may ask of the parser, looked at before it is parsed: the parser makes a table of each
// part of a dotted key, and takes them apart again by recursion. Whether a character beyond ASCII is a blank
// it decides by a branch that its authors declare unreachable and some characters reach (toml++ 3.3,
// is_non_ascii_horizontal_whitespace()). Pure; thread-safe; no allocation but for the message; time and stack
// by the text's length alone.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "common/result.hpp"

namespace strobe::config {

inline constexpr std::size_t kMaxToml_bytes = 1u << 20;
inline constexpr int kMaxKeyParts = 16;      ///< of a dotted key, or of a table's name
inline constexpr int kMaxOpenBrackets = 16;  ///< of arrays and inline tables within each other

/// Why the text must not be parsed: it is too long, nests deeper than any file of ours, or has characters
/// beyond ASCII outside of quotes and comments, which TOML knows nowhere else, or behind a backslash. Absent:
/// it may be; what the parser makes of it is then some 350 tables deep at most. Any bytes. The message begins
/// with the line, "7: ".
std::optional<Error> toml_bounds_problem(std::string_view text);

}  // namespace strobe::config
