// Records of an LCM event log, as lcm/eventlog.c writes them: sync word, number, time, sizes, channel,
// message; numbers big-endian. Allocates; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace strobe::wire {

inline constexpr std::uint32_t kLogSyncWord = 0xEDA1DA01;
/// The same as in a file. No text in UTF-8 holds it.
inline constexpr std::string_view kLogSync_bytes = "\xED\xA1\xDA\x01";

/// Adds one record to a container of bytes or chars. time_us: CLOCK_REALTIME.
template <typename Container>
void append_log_record(Container& out, std::int64_t number, std::int64_t time_us, std::string_view channel,
                       std::span<const std::uint8_t> message) {
  const auto put = [&out](std::uint64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8)
      out.push_back(static_cast<typename Container::value_type>(value >> shift & 0xff));
  };
  put(kLogSyncWord, 4);
  put(static_cast<std::uint64_t>(number), 8);
  put(static_cast<std::uint64_t>(time_us), 8);
  put(channel.size(), 4);
  put(message.size(), 4);
  out.insert(out.end(), channel.begin(), channel.end());
  out.insert(out.end(), message.begin(), message.end());
}

}  // namespace strobe::wire
