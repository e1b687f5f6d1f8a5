// JSON of a measured method, shared by `strobe predict` and `strobe reduce`. Pure; thread-safe.
#pragma once

#include <nlohmann/json.hpp>

#include "common/frontier/frontier.hpp"

namespace strobe::host {

/// Method, parameter, and the measured error and cost.
nlohmann::ordered_json row_json(const frontier::Row& row);

}  // namespace strobe::host
