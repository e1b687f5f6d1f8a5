// How things are, as JSON: see host/web/README.md. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "host/web/live/live_message.hpp"

namespace strobe::web {

nlohmann::ordered_json status_json(const LiveStatus& status);

}  // namespace strobe::web
