// How a status tells that outputs may be active which nobody can switch off: its message begins with these words.
// Plain values.
#pragma once

#include <string_view>

namespace strobe::messages {

inline constexpr std::string_view kDangerWords = "THE OUTPUTS MAY BE ACTIVE";

constexpr bool tells_danger(std::string_view status_message) {
  return status_message.starts_with(kDangerWords);
}

}  // namespace strobe::messages
