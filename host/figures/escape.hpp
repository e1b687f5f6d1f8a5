// Text into HTML that is well-formed XML, too. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>

namespace strobe::figures {

/// Shown as it is, also within attributes in double quotes. Bytes that are not UTF-8, and characters that
/// documents must not hold (controls), become U+FFFD; so do those that would turn the order of what follows
/// (bidirectional controls).
std::string escaped(std::string_view text);

}  // namespace strobe::figures
