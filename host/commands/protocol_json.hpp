// What a protocol says of shots, as JSON: of `strobe protocol verdict` and `strobe fire --protocol`. Pure;
// thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "host/protocol/evaluation.hpp"
#include "host/protocol/protocol.hpp"

namespace strobe::host {

nlohmann::ordered_json evaluation_json(const protocol::Protocol& protocol,
                                       const protocol::Evaluation& evaluation);

}  // namespace strobe::host
