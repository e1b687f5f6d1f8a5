// JSON that others wrote, parsed: what nests deeper than any of ours is no JSON to us, since a value is copied and printed by
// recursion. Pure; thread-safe; allocates.
#pragma once

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>

namespace strobe::messages {

inline constexpr int kMaxJsonDepth = 64;

/// Of arrays and objects within each other; more than kMaxJsonDepth are not counted. Any bytes.
inline int json_depth(std::string_view text) {
  int depth = 0, deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < text.size() && deepest <= kMaxJsonDepth; ++i) {
    const char c = text[i];
    if (c == '"') quoted = !quoted;
    if (quoted && c == '\\') ++i;
    if (quoted) continue;
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if (c == ']' || c == '}') --depth;
  }
  return deepest;
}

/// is_discarded() if it is no JSON, or nests too deep.
template <typename Json>
Json parsed_json(std::string_view text) {
  if (json_depth(text) > kMaxJsonDepth) return Json(Json::value_t::discarded);
  return Json::parse(text, nullptr, false);
}

}  // namespace strobe::messages
