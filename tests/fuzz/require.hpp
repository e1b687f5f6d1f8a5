// What every fuzzing target asks of what it tries.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace strobe::fuzz {

inline void require(bool holds) {
  if (!holds) std::abort();
}

/// An error for people: one line that begins with the file's name.
inline void require_one_line(std::string_view message, std::string_view file) {
  require(message.starts_with(file) && message.find('\n') == message.npos);
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace strobe::fuzz
