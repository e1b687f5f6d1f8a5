#include "host/session/log_files.hpp"

#include <algorithm>
#include <string>
#include <string_view>

namespace strobe::host {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> logs_named(const fs::path& folder, std::string_view before, std::error_code& error) {
  std::vector<fs::path> found;
  error.clear();
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.starts_with(before) && name.ends_with(".lcmlog")) found.push_back(entry->path());
  }
  std::ranges::sort(found);
  return found;
}

}  // namespace

std::vector<fs::path> host_logs(const fs::path& folder, std::error_code& error) {
  return logs_named(folder, "host-", error);
}

std::vector<fs::path> journals(const fs::path& folder, std::error_code& error) {
  return logs_named(folder, "journal-", error);
}

std::vector<fs::path> host_logs(const fs::path& folder) {
  std::error_code ignored;
  return host_logs(folder, ignored);
}

std::vector<fs::path> journals(const fs::path& folder) {
  std::error_code ignored;
  return journals(folder, ignored);
}

}  // namespace strobe::host
