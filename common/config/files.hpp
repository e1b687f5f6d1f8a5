// Files as a whole or by their lines: what a person wrote, what comes with the programs, what they keep.
// Reads and writes files, reads the environment and /proc; call it from one thread.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "common/result.hpp"

namespace strobe::config {

/// The whole file as text, at most 16 MB. "-" is standard input. Fails with the file's name.
Result<std::string> read_file(const std::string& path);
/// Likewise; absent: there is no such file. Not "-".
Result<std::optional<std::string>> read_file_if_any(const std::filesystem::path& path);

inline constexpr std::size_t kMaxLine_bytes = 1u << 20;
/// Hands on the lines of a file of any size, each without its end, with whether it had one. False: there is
/// no such file. Fails with the file's name: it cannot be read, or a line is longer than kMaxLine_bytes.
Result<bool> read_lines(const std::filesystem::path& path,
                        const std::function<void(std::string_view line, bool ended)>& on_line);

/// Once it returns, the whole text is on the disk under this name; if it fails, what was there before still
/// is: a file of another name is written first, then renamed. Devices and pipes are written as they are.
/// Fails with the file's name and the system's reason.
Result<void> write_file(const std::filesystem::path& path, std::string_view text);

/// Likewise a copy of another file.
Result<void> copy_file(const std::filesystem::path& from, const std::filesystem::path& to);

/// Writes all bytes to a descriptor, in as many calls as it takes. False: errno says why.
bool write_all(int fd, std::string_view bytes);

/// What was made, renamed or removed in the folder is on the disk. False: errno says why.
bool sync_folder(const std::filesystem::path& folder);

/// Where scenes, the thesis's tables and the example rig file are: $STROBE_SHARE if set, else
/// ../share/strobe beside the executable's folder. Fails if that folder does not exist; the message names it.
Result<std::filesystem::path> share_folder();

}  // namespace strobe::config
