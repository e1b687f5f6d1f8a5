// Who a host is, for a person. A host says so in a note of its ARM; strobed puts it behind the host's id in the detail
// of the ARMED event. Hosts and firmware that do not know of it leave it out and read past it. Plain values.
#pragma once

#include <string_view>

namespace strobe::messages {

/// Key of the note; its value is "login@machine".
inline constexpr std::string_view kHostNameNote = "host_name";

/// The name in an ARMED event's detail, "1f2e login@machine"; empty: there is none.
constexpr std::string_view host_name_in(std::string_view armed_detail) {
  const std::size_t blank = armed_detail.find(' ');
  return blank == armed_detail.npos ? std::string_view() : armed_detail.substr(blank + 1);
}

}  // namespace strobe::messages
