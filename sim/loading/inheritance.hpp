// A scene's document merged with those it inherits from. Implementation of parse_scene.hpp; allocates, no I/O
// of its own.
#pragma once

#include <string>

#include "common/config/toml_reader.hpp"
#include "sim/loading/parse_scene.hpp"

namespace strobe::sim {

/// Merges the chain of parents that the document's key `inherits` begins. Where the child chooses another of
/// several ways to say one thing (the contact's law, e and dwell time or springs, …), the parent's way is
/// dropped. Errors: as parse_scene().
Result<config::TomlReader> with_inherited(config::TomlReader child, const std::string& file_name,
                                          const SceneResolver& resolve);

}  // namespace strobe::sim
