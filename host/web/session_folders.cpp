#include "host/web/session_folders.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <system_error>

#include "host/session/session_logs.hpp"
#include "host/web/http/message.hpp"

namespace strobe::web {
namespace {

namespace fs = std::filesystem;

bool is_own_folder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(fs::symlink_status(path, error));
}

bool holds_session(const fs::path& folder) {
  return is_own_file(folder, folder / "results.csv") || !host::host_logs(folder).empty() ||
         !host::journals(folder).empty();
}

/// Length of the UTF-8 sequence there that is no control character and no %; 0: it is none.
std::size_t plain_length(const std::string& text, std::size_t at) {
  if (text[at] == '%') return 0;
  for (std::size_t length = 1; length <= std::min<std::size_t>(4, text.size() - at); ++length)
    if (is_plain_text(std::string_view(text).substr(at, length))) return length;
  return 0;
}

}  // namespace

std::string session_id(const std::string& folder_name) {
  std::string id;
  for (std::size_t at = 0; at < folder_name.size();) {
    const std::size_t plain = plain_length(folder_name, at);
    if (plain == 0) id += fmt::format("%{:02X}", static_cast<unsigned char>(folder_name[at]));
    id += folder_name.substr(at, plain);
    at += std::max<std::size_t>(1, plain);
  }
  return id;
}

std::vector<fs::path> session_folders(const fs::path& sessions) {
  std::vector<fs::path> folders;
  std::error_code error;
  for (fs::directory_iterator entry(sessions, error), end; !error && entry != end; entry.increment(error)) {
    const fs::path path = sessions / entry->path().filename();
    if (is_own_folder(path) && holds_session(path)) folders.push_back(path);
  }
  std::ranges::sort(folders);
  return folders;
}

std::optional<fs::path> session_folder(const fs::path& sessions, const std::string& id) {
  if (id.empty() || id.size() > 1024 || id == "." || id == ".." || id.find('/') != std::string::npos ||
      id.find('\0') != std::string::npos)
    return std::nullopt;
  if (session_id(id) == id) {  // its name
    fs::path path = sessions / id;
    return is_own_folder(path) && holds_session(path) ? std::optional(std::move(path)) : std::nullopt;
  }
  for (fs::path& path : session_folders(sessions))
    if (session_id(path.filename().string()) == id) return std::move(path);
  return std::nullopt;
}

bool is_own_file(const fs::path& folder, const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(file, error))) return false;
  const fs::path relative = file.lexically_relative(folder);
  fs::path below = folder;
  for (auto part = relative.begin(); part != relative.end(); ++part) {
    if (*part == "..") return false;
    below /= *part;
    if (std::next(part) != relative.end() && !is_own_folder(below)) return false;
  }
  return !relative.empty();
}

FileStamp stamp_of(const fs::path& file) {
  std::error_code error;
  FileStamp stamp;
  stamp.bytes = fs::file_size(file, error);
  if (error) return {};
  const auto changed = fs::last_write_time(file, error);
  if (error) return {};
  stamp.changed = changed.time_since_epoch().count();
  return stamp;
}

}  // namespace strobe::web
