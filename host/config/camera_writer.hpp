// Puts what was calibrated into a rig file's [camera] table; every other byte of the file stays. Pure but for
// replace_file; thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/result.hpp"
#include "host/config/camera_table.hpp"

namespace strobe::host {

/// The rig file's text with the calibration's keys of `camera` in its [camera] table: folder, max_age_days
/// and comments stay, older keys of a calibration go. Fails with "FILE:LINE: what" if the table is not
/// written as [camera] with one key a line.
Result<std::string> with_calibration(std::string_view text, const std::string& file_name,
                                     const CameraTable& camera);

/// Writes a new file beside it and renames it, so that at any time there is a whole one; its permissions
/// stay, and a link stays one. Fails with the file's name.
Result<void> replace_file(const std::string& path, std::string_view text);

}  // namespace strobe::host
