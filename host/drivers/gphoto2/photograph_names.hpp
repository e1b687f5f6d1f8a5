// Names of a camera's files: which are photographs, which belong together, under what name they are stored
// here. Pure but for free_name(); thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace strobe::gphoto2 {

enum class FileKind {
  raw,
  developed,  ///< TIFF, PNG: all that some cameras write
  jpeg,
  other,  ///< films, sounds, sidecars
};
FileKind file_kind(const std::string& name);

/// What a RAW file and the JPEG beside it have in common: the name without its extension.
std::string stem_of(const std::string& name);

/// The last run of digits in the stem: 42 of DSC_0042.NEF; -1: there is none, or it is no number of a file.
std::int64_t file_number(const std::string& name);

/// Letters, digits, '.', '_' and '-' stay, others become '_'; so does a '.' at the beginning. Never empty.
std::string safe_name(const std::string& name);

/// The name, or that with -2, -3 … before its extension, so that no file of the folder is overwritten:
/// cameras begin again with DSC_0001.
std::string free_name(const std::filesystem::path& folder, const std::string& name);

}  // namespace strobe::gphoto2
