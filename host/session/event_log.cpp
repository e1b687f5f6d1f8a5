#include "host/session/event_log.hpp"

#include <cerrno>

#include "common/wire/lcm_log_record.hpp"

namespace strobe::host {
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
