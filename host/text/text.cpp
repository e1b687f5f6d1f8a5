#include "host/text/text.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

namespace strobe::host {

std::size_t columns(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string cut(std::string_view text, std::size_t width) {
  std::string result = fmt::format("{:.{}}", text, width);
  if (result.size() < text.size()) result = width > 0 ? fmt::format("{:.{}}…", text, width - 1) : "";
  std::replace_if(
      result.begin(), result.end(), [](char c) { return (c >= 0 && c < 0x20) || c == 0x7F; }, ' ');
  return result;
}

std::string left(std::string_view text, std::size_t width) {
  return fmt::format("{:<{}}", cut(text, width), width);
}

std::string right(std::string_view text, std::size_t width) {
  return fmt::format("{:>{}}", cut(text, width), width);
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width, std::string_view indent) {
  std::vector<std::string> lines{""};
  for (std::size_t begin = 0, end = 0; begin <= text.size(); begin = end + 1) {
    end = std::min(text.find(' ', begin), text.size());
    const std::string_view word = text.substr(begin, end - begin);
    const bool begins = lines.back().empty();
    if (!begins && columns(lines.back()) + 1 + columns(word) > width)
      lines.push_back(std::string(indent) + std::string(word));
    else
      lines.back() += (begins ? "" : " ") + std::string(word);
  }
  return lines;
}

std::string rounded(double value, double sd, int least) {
  int decimals = 3;
  if (std::isfinite(sd) && sd > 0.0) decimals = 1 - static_cast<int>(std::floor(std::log10(sd)));
  return fmt::format("{:.{}f}", value, std::clamp(decimals, least, 6));
}

}  // namespace strobe::host
