// What the interface says of a host that runs, and asks of it.
#pragma once

#include "host/web/http/router.hpp"
#include "host/web/live/live_state.hpp"

namespace strobe::web {

/// /api/v1/live, /timing, and to stop and to disarm. The state must outlive the router. All answer quickly.
void add_live_routes(Router& router, LiveState& state);

}  // namespace strobe::web
