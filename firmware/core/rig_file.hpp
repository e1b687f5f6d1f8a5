// rig.toml to Rig. Every value is checked; the first error names file, line and key. Pure; allocates;
// thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// file_name is for messages only. [ball], [analysis] and [camera] are the host's and accepted as they stand.
Result<Rig> read_rig(std::string_view text, const std::string& file_name);

}  // namespace strobe::firmware
