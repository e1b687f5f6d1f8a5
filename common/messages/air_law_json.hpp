// The law of drag and lift of a kind of ball (common/flight/air_law.hpp) to and from JSON, its fields by
// their names. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "common/flight/air_law.hpp"
#include "common/result.hpp"

namespace strobe::messages {

nlohmann::ordered_json air_law_json(const flight::AirLaw& law);

/// Fails with "air_law: what" or "air_law.field: what"; ranges are the frame's to check.
Result<flight::AirLaw> air_law_from_json(const nlohmann::json& object);

}  // namespace strobe::messages
