// Photographs as files, written as a tethered camera does: under a temporary name without an image's
// extension, then renamed. Thread-safe for different files; writes files.
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/result.hpp"
#include "common/units/time.hpp"
#include "sim/scene/photograph_settings.hpp"

namespace strobe::sim {

/// ".tif" or ".png"
std::string extension(PhotographFormat format);

/// Uncompressed TIFF, or PNG. The file appears complete under its name, over an older one. `written`: its
/// time of last change, the machine's if none is given. The error names the file.
Result<void> write_photograph(const std::filesystem::path& path, const cv::Mat& pixels,
                              PhotographFormat format, std::optional<WallTime> written = std::nullopt);

}  // namespace strobe::sim
