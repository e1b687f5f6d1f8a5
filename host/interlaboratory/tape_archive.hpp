// Files as one uncompressed tar (GNU), and back. The same files give the same bytes. What others
// made is unpacked with suspicion: no name that leads elsewhere, no links, no devices, no more bytes than the
// archive has. Reads and writes files by libarchive; one thread's.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/result.hpp"

namespace strobe::interlaboratory {

struct PackedFile {
  std::string name;            ///< in the archive
  std::filesystem::path from;  ///< empty: it holds `text`
  std::string text;
};

/// In the order given; mtime_s: of all, since 1970. The archive is there whole or not at all. Fails with the
/// name of the file that cannot be read or written, or changes meanwhile.
Result<void> pack(const std::filesystem::path& archive, const std::vector<PackedFile>& files,
                  std::int64_t mtime_s);

/// Whether an entry of this name may be unpacked: relative, each of its parts a name, without control
/// characters.
bool is_safe_name(const std::string& name);

/// Unpacks into an empty folder; returns the names of the files in the order of the archive. Fails at the
/// first entry that is not a plain file or folder within, with "ARCHIVE: ENTRY: what".
Result<std::vector<std::string>> unpack(const std::filesystem::path& archive,
                                        const std::filesystem::path& into);

}  // namespace strobe::interlaboratory
