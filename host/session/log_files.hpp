// The LCM logs in a session's folder, by their names. Reads folders.
#pragma once

#include <filesystem>
#include <system_error>
#include <vector>

namespace strobe::host {

/// The hosts' logs in the folder, in the order of their names, which is that of their starts. `error`: why the folder
/// could not be read to its end.
std::vector<std::filesystem::path> host_logs(const std::filesystem::path& folder, std::error_code& error);
/// The firmware's journals in the folder, in the order of their names, which says nothing.
std::vector<std::filesystem::path> journals(const std::filesystem::path& folder, std::error_code& error);

/// The same where a folder that cannot be read is like one without logs.
std::vector<std::filesystem::path> host_logs(const std::filesystem::path& folder);
std::vector<std::filesystem::path> journals(const std::filesystem::path& folder);

}  // namespace strobe::host
