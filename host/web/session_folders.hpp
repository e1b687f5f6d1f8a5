// The sessions in a folder, by what a request may call them. Reads folders; thread-safe. No link is followed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace strobe::web {

/// What a session is called: its folder's name. Bytes that are no UTF-8, control characters and % are written
/// %FF, so that every folder has an id and no two have the same.
std::string session_id(const std::string& folder_name);

/// Folders right below `sessions` that hold a log, a journal or results, in the order of their names.
std::vector<std::filesystem::path> session_folders(const std::filesystem::path& sessions);

/// The one of this id, if session_folders() would list it. Any text.
std::optional<std::filesystem::path> session_folder(const std::filesystem::path& sessions,
                                                    const std::string& id);

/// Whether it is a file, no link, whose folders below `folder` are no links either.
bool is_own_file(const std::filesystem::path& folder, const std::filesystem::path& file);

/// Tells one state of a file from another.
struct FileStamp {
  std::uintmax_t bytes = 0;
  std::int64_t changed = 0;  ///< in ticks of the file system's clock; 0: there is no such file
  auto operator<=>(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::filesystem::path& file);

}  // namespace strobe::web
