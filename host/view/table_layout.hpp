// Widths that the tables of shots and series have in common. Pure; thread-safe.
#pragma once

#include <string>
#include <vector>

#include "host/view/text.hpp"

namespace strobe::host {

inline constexpr std::size_t kNameWidth = 17;
inline constexpr std::size_t kUnitWidth = 6;
inline constexpr std::size_t kNumberWidth = 10;

/// Each line cut to the width, without spaces at its end.
inline std::vector<std::string> fitted(std::vector<std::string> lines, std::size_t width) {
  for (std::string& line : lines) {
    line = cut(line, width);
    while (!line.empty() && line.back() == ' ') line.pop_back();
  }
  return lines;
}

}  // namespace strobe::host
