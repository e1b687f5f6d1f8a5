#include "host/web/http/target.hpp"

#include <cstdint>
#include <optional>

namespace strobe::web {
namespace {

std::optional<unsigned> digit(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a') + 10;
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A') + 10;
  return std::nullopt;
}

std::optional<std::string> decoded(std::string_view text, bool plus_is_blank) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '+' && plus_is_blank) {
      plain += ' ';
    } else if (text[i] != '%') {
      plain += text[i];
    } else {
      if (text.size() - i < 3) return std::nullopt;
      const auto high = digit(text[i + 1]), low = digit(text[i + 2]);
      if (!high || !low) return std::nullopt;
      plain += static_cast<char>(*high << 4 | *low);
      i += 2;
    }
  }
  if (!is_plain_text(plain)) return std::nullopt;
  return plain;
}

/// Bytes of the character that begins with this one; 0: none does.
std::size_t length_of_character(unsigned char first) {
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return 2;
  if (first >= 0xE0 && first <= 0xEF) return 3;
  return first >= 0xF0 && first <= 0xF4 ? 4 : 0;
}

bool is_character(std::string_view bytes) {
  std::uint32_t code = static_cast<unsigned char>(bytes[0]);
  if (bytes.size() == 1) return code >= 0x20 && code != 0x7F;
  code &= 0x7Fu >> bytes.size();
  for (const char c : bytes.substr(1)) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xC0) != 0x80) return false;
    code = code << 6 | (byte & 0x3F);
  }
  if (bytes.size() == 2) return code >= 0xA0;  // below are control characters
  if (bytes.size() == 3) return code >= 0x800 && (code < 0xD800 || code > 0xDFFF);
  return code >= 0x10000 && code <= 0x10FFFF;
}

}  // namespace

bool is_plain_text(std::string_view text) {
  while (!text.empty()) {
    const std::size_t length = length_of_character(static_cast<unsigned char>(text[0]));
    if (length == 0 || length > text.size() || !is_character(text.substr(0, length))) return false;
    text.remove_prefix(length);
  }
  return true;
}

Result<Target> parse_target(std::string_view text) {
  if (!text.starts_with('/')) return fail("the target must be a path");
  const std::size_t mark = text.find('?');
  const auto path = decoded(text.substr(0, mark), false);
  if (!path) return fail("the path is no escaped UTF-8");
  Target target{*path, {}};
  std::string_view rest = mark == text.npos ? std::string_view() : text.substr(mark + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    if (pair.empty()) continue;
    const std::size_t equals = std::min(pair.find('='), pair.size());
    const auto name = decoded(pair.substr(0, equals), true);
    const auto value = decoded(pair.substr(std::min(pair.size(), equals + 1)), true);
    if (!name || !value) return fail("the query is no escaped UTF-8");
    target.query.emplace(*name, *value);
  }
  return target;
}

}  // namespace strobe::web
