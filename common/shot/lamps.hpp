// Which of the two strobe lamps. Plain values; real-time safe.
#pragma once

#include <cstdint>

namespace strobe {

enum class Lamps : std::int8_t { a = 1, b = 2, both = 3 };  ///< bits; values are those of coded_flash_t

constexpr bool has_a(Lamps lamps) { return (static_cast<int>(lamps) & 1) != 0; }
constexpr bool has_b(Lamps lamps) { return (static_cast<int>(lamps) & 2) != 0; }

}  // namespace strobe
