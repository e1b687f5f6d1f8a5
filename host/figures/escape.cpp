#include "host/figures/escape.hpp"

#include <glib.h>

namespace strobe::figures {

namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

bool may_stand(gunichar c) {
  if (c == '\n' || c == '\t') return true;
  const bool control = c < 0x20 || (c >= 0x7F && c < 0xA0);
  const bool turns = (c >= 0x202A && c <= 0x202E) || (c >= 0x2066 && c <= 0x2069) || c == 0x200E ||
                     c == 0x200F || c == 0x061C;
  const bool no_character = (c & 0xFFFE) == 0xFFFE || (c >= 0xFDD0 && c <= 0xFDEF);
  return !control && !turns && !no_character;
}

void append(std::string& out, gunichar c, std::string_view bytes) {
  switch (c) {
    case '&':
      out += "&amp;";
      break;
    case '<':
      out += "&lt;";
      break;
    case '>':
      out += "&gt;";
      break;
    case '"':
      out += "&quot;";
      break;
    case '\'':
      out += "&#39;";
      break;
    default:
      out += may_stand(c) ? bytes : kReplacement;
  }
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const gunichar c = g_utf8_get_char_validated(text.data(), static_cast<gssize>(text.size()));
    if (c == 0 || (c & 0x80000000U) != 0) {  // a NUL, or no character
      out += kReplacement;
      text.remove_prefix(1);
      continue;
    }
    const auto length = static_cast<std::size_t>(g_utf8_skip[static_cast<unsigned char>(text.front())]);
    append(out, c, text.substr(0, length));
    text.remove_prefix(length);
  }
  return out;
}

}  // namespace strobe::figures
