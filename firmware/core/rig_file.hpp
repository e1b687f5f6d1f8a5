// Reads rig.toml. Every value is checked; the first error names file, line and key. Pure; allocates;
// thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"
#include "firmware/core/rig.hpp"

namespace strobe::firmware {

/// file_name: for errors. [ball], [analysis] and [camera] belong to the host and are not checked.
Result<Rig> read_rig(std::string_view text, const std::string& file_name);

}  // namespace strobe::firmware
