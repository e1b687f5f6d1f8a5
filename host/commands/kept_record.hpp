// A session keeps the record of commissioning of the rig that it was fired on. Reads and writes files; not thread-safe.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "host/config/rig_file.hpp"

namespace strobe::host {

/// Copies the rig file's record, if there is one, into the session's folder. rig_path: empty for the shipped example, which is
/// nobody's rig. Returns a sentence for the operator if the rig is not commissioned, or not well; else empty. Fails with the
/// file's name.
Result<std::string> keep_commission_record(const std::filesystem::path& rig_path, const RigFile& rig,
                                           const std::filesystem::path& session, WallTime now);

}  // namespace strobe::host
