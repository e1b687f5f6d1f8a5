// Texts in messages that programs read. How a status tells that outputs may be active which nobody can switch
// off: its message begins with these words. Plain values; thread-safe.
#pragma once

#include <charconv>
#include <cstdint>
#include <string_view>

namespace strobe::messages {

inline constexpr std::string_view kDangerWords = "THE OUTPUTS MAY BE ACTIVE";

constexpr bool tells_danger(std::string_view status_message) {
  return status_message.starts_with(kDangerWords);
}

// Who a host is, for a person. A host says so in a note of its ARM; strobed puts it behind the host's id in
// the detail of the ARMED event. Hosts and firmware that do not know of it leave it out and read past it.

/// Key of the note; its value is "login@machine".
inline constexpr std::string_view kHostNameNote = "host_name";

/// The name in an ARMED event's detail, "1f2e login@machine"; empty: there is none.
constexpr std::string_view host_name_in(std::string_view armed_detail) {
  const std::size_t blank = armed_detail.find(' ');
  return blank == armed_detail.npos ? std::string_view() : armed_detail.substr(blank + 1);
}

/// Its host_id; 0: there is none.
inline std::int64_t host_id_in(std::string_view armed_detail) {
  std::uint64_t host = 0;
  std::from_chars(armed_detail.data(), armed_detail.data() + armed_detail.size(), host, 16);
  return static_cast<std::int64_t>(host);
}

}  // namespace strobe::messages
