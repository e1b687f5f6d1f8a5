// A camera's RAW file, read by strobe-raw (host/drivers/raw): a program of its own, since what decodes such
// files is a large library that only some laboratories need, and meets bytes of strangers.
#pragma once

#include <filesystem>
#include <vector>

#include "common/result.hpp"

namespace strobe::external {

/// By its ending: .dng, .cr2, .nef ..., in either case.
bool is_raw_name(const std::filesystem::path& file);

/// The bytes of a TIFF file of the sensor's numbers (common/image/image_files.hpp). Takes a second or less
/// for 20 megapixels, and ends after a minute. Fails with one line without the file's name: strobe-raw's own,
/// or what to install. Thread-safe; writes into a temporary folder of its own.
Result<std::vector<unsigned char>> mosaic_of_raw_file(const std::filesystem::path& file);

}  // namespace strobe::external
