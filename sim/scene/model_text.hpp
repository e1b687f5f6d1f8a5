// Models as text, for the command line. Pure; thread-safe; allocates.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"
#include "sim/scene/model.hpp"

namespace strobe::sim {

/// "full", "none", a list of the effects to have ("gravity,grip"), or of those to leave out of the full model
/// ("-pixels,-drag"; "full-pixels-drag" is the same). The error names the word.
Result<Model> parse_model(std::string_view text);

/// "full", "none", or the list of effects, whichever is the shortest of the forms above.
std::string model_text(const Model& model);

}  // namespace strobe::sim
