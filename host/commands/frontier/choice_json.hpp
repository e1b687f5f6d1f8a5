// The parts of a choice's JSON that `strobe predict` and `strobe reduce` share.
#pragma once

#include <nlohmann/json.hpp>

#include "common/frontier/frontier.hpp"
#include "host/view/or_null.hpp"

namespace strobe::host {

/// The method, its parameter, and what the measured frontier says of its error and cost.
nlohmann::ordered_json row_json(const frontier::Row& row);

}  // namespace strobe::host
