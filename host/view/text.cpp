#include "host/view/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace strobe::host {
namespace {

bool continues(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

std::size_t bytes_of(std::string_view text, std::size_t width) {
  std::size_t seen = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!continues(text[i]) && seen++ == width) return i;
  }
  return text.size();
}

std::string spaces(std::size_t count) { return std::string(count, ' '); }

}  // namespace

std::size_t columns(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return !continues(c); }));
}

std::string cut(std::string_view text, std::size_t width) {
  std::string result;
  if (columns(text) <= width) {
    result = text;
  } else if (width > 0) {
    result = std::string(text.substr(0, bytes_of(text, width - 1))) + "…";
  }
  for (char& c : result) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F) c = ' ';
  }
  return result;
}

std::string left(std::string_view text, std::size_t width) {
  const std::string shown = cut(text, width);
  return shown + spaces(width - columns(shown));
}

std::string right(std::string_view text, std::size_t width) {
  const std::string shown = cut(text, width);
  return spaces(width - columns(shown)) + shown;
}

std::string rounded(double value, double sd, int least) {
  int decimals = 3;
  if (std::isfinite(sd) && sd > 0.0) decimals = 1 - static_cast<int>(std::floor(std::log10(sd)));
  return fmt::format("{:.{}f}", value, std::clamp(decimals, least, 6));
}

}  // namespace strobe::host
