// Names that were mistyped: of options, commands and keys. Pure; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace strobe::config {

/// The name that was probably meant: one that differs by a letter or two left out, added, changed or swapped,
/// or that begins with what was typed. Letters of either case; leading dashes do not count.
std::optional<std::string> nearest(const std::string& typed, const std::vector<std::string>& names);

/// "; did you mean NAME?", or nothing if no name is near.
std::string did_you_mean(const std::string& typed, const std::vector<std::string>& names);

}  // namespace strobe::config
