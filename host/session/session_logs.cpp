#include "host/session/session_logs.hpp"

#include <algorithm>
#include <cerrno>
#include <string>
#include <string_view>

#include "common/wire/lcm_log_record.hpp"

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

namespace {

/// "FRAME" of STROBE/bench/FRAME.
std::string_view kind_of(const std::string& channel) {
  return std::string_view(channel).substr(channel.rfind('/') + 1);
}

}  // namespace

Result<EventLog> EventLog::create(const std::filesystem::path& folder, const std::string& utc) {
  std::string name = "host-" + utc;
  for (char letter = 'b';; ++letter) {
    auto file = RecordFile::open(folder / (name + ".lcmlog"), RecordFile::Use::anew);
    if (file) return EventLog(std::move(*file));
    if (errno != EEXIST || letter > 'z') return tl::unexpected(file.error());
    name = "host-" + utc + letter;
  }
}

Result<void> EventLog::append(const std::string& channel, std::span<const std::uint8_t> message,
                              WallTime wall) {
  const auto time_us = std::chrono::floor<microseconds>(wall).time_since_epoch().count();
  std::string record;
  record.reserve(28 + channel.size() + message.size());
  wire::append_log_record(record, next_number_++, time_us, channel, message);
  return file_.append(std::move(record), kind_of(channel));
}

}  // namespace strobe::host
