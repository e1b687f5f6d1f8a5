#include "host/archive/stored_logs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <chrono>
#include <fstream>
#include <optional>
#include <system_error>

namespace strobe::host {
namespace {

namespace fs = std::filesystem;

std::optional<int> digits(std::string_view text, std::size_t from, std::size_t count) {
  int number = 0;
  if (text.size() < from + count) return std::nullopt;
  const char* begin = text.data() + from;
  const auto read = std::from_chars(begin, begin + count, number);
  if (read.ec != std::errc() || read.ptr != begin + count) return std::nullopt;
  return number;
}

/// Of host-20260131T093000Z.lcmlog; a log of another name may begin at any time.
WallTime start_in(const std::string& name) {
  constexpr std::size_t kDate = 5;
  const auto year = digits(name, kDate, 4), month = digits(name, kDate + 4, 2),
             day = digits(name, kDate + 6, 2);
  const auto hour = digits(name, kDate + 9, 2), minute = digits(name, kDate + 11, 2),
             second = digits(name, kDate + 13, 2);
  if (!name.starts_with("host-") || !year || !month || !day || !hour || !minute || !second) return {};
  const std::chrono::year_month_day date(std::chrono::year(*year),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day)));
  if (!date.ok() || *year < 1970 || *year > 2200) return {};
  return WallTime{std::chrono::sys_days{date}} + std::chrono::hours{*hour} + std::chrono::minutes{*minute} +
         std::chrono::seconds{*second};
}

}  // namespace

Result<StoredLogs> StoredLogs::open(std::vector<fs::path> paths) {
  std::vector<Log> logs;
  for (fs::path& path : paths) {
    Log log;
    std::error_code error;
    log.bytes = fs::file_size(path, error);
    if (error || !fs::is_regular_file(path, error)) return fail(path.string() + ": no such file or folder");
    if (!std::ifstream(path).good()) return fail(path.string() + ": cannot be read");
    log.starts = start_in(path.filename().string());
    log.path = std::move(path);
    logs.push_back(std::move(log));
  }
  return StoredLogs(std::move(logs));
}

StoredLogs::StoredLogs(std::vector<Log> logs) : logs_(std::move(logs)) {
  std::ranges::stable_sort(logs_, {}, &Log::starts);
}

bool StoredLogs::advance(Log& log) {
  if (!log.reader) return false;
  if (!log.reader->next(log.record)) return log.reader.reset(), false;
  log.read += wire::kLogHeaderSize + log.record.channel.size() + log.record.bytes.size();
  // A wall clock may have been set.
  log.time = std::max(log.time, WallTime{microseconds{log.record.wall_us}});
  return true;
}

/// Logs that may hold what comes next.
void StoredLogs::open_due() {
  const auto next_time = [this] {
    std::optional<WallTime> time;
    for (const Log& log : logs_)
      if (log.reader && (!time || log.time < *time)) time = log.time;
    return time;
  };
  while (opened_ < logs_.size()) {
    const auto time = next_time();
    if (time && logs_[opened_].starts > *time) return;
    Log& log = logs_[opened_++];
    log.reader = std::make_unique<wire::LogReader>(log.path);
    advance(log);
  }
}

std::optional<LogMessage> StoredLogs::next() {
  if (last_ != nullptr) advance(*last_);
  last_ = nullptr;
  open_due();
  for (Log& log : logs_)
    if (log.reader && (last_ == nullptr || log.time < last_->time)) last_ = &log;
  if (last_ == nullptr) return std::nullopt;
  ++messages_;
  assert(last_->reader);
  return LogMessage{last_->record.channel, last_->record.bytes, last_->time,
                    static_cast<std::size_t>(last_ - logs_.data())};
}

double StoredLogs::share() const {
  std::uintmax_t bytes = 0, read = 0;
  for (const Log& log : logs_) {
    bytes += log.bytes;
    read += log.read;
  }
  return bytes == 0 ? 1.0 : std::min(1.0, static_cast<double>(read) / static_cast<double>(bytes));
}

std::vector<std::string> StoredLogs::remarks() const {
  std::vector<std::string> lines;
  for (const Log& log : logs_) {
    if (log.read >= log.bytes) continue;
    lines.push_back(
        fmt::format("{}: {} of {} bytes cannot be read as messages: a write was cut short, or the file "
                    "was damaged",
                    log.path.filename().string(), log.bytes - log.read, log.bytes));
  }
  return lines;
}

}  // namespace strobe::host
