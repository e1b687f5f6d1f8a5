#include "host/session/event_log.hpp"

#include <cerrno>

namespace strobe::host {
namespace {

constexpr std::uint32_t kRecordMark = 0xEDA1DA01;  // lcm/eventlog.c

template <typename Number>
void put(std::string& record, Number number) {
  for (int shift = 8 * static_cast<int>(sizeof number) - 8; shift >= 0; shift -= 8)
    record.push_back(static_cast<char>(number >> shift & 0xff));
}

/// "FRAME" of STROBE/bench/FRAME.
std::string_view kind_of(const std::string& channel) {
  return std::string_view(channel).substr(channel.rfind('/') + 1);
}

}  // namespace

Result<EventLog> EventLog::create(const std::filesystem::path& folder, const std::string& utc) {
  std::string name = "host-" + utc;
  for (char letter = 'b';; ++letter) {
    auto file = RecordFile::open(folder / (name + ".lcmlog"), RecordFile::Use::alone);
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
  put(record, kRecordMark);
  put(record, static_cast<std::uint64_t>(next_number_++));
  put(record, static_cast<std::uint64_t>(time_us));
  put(record, static_cast<std::uint32_t>(channel.size()));
  put(record, static_cast<std::uint32_t>(message.size()));
  record += channel;
  record.append(reinterpret_cast<const char*>(message.data()), message.size());
  return file_.append(std::move(record), kind_of(channel));
}

}  // namespace strobe::host
