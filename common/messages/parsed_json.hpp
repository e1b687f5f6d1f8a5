// JSON to and from text, compiled once for all that reads or writes it. What others wrote and nests deeper
// than any of ours is no JSON to us, since a value is copied and printed by recursion. Pure; thread-safe;
// allocates.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace strobe::messages {

inline constexpr int kMaxJsonDepth = 64;

/// Of arrays and objects within each other; more than kMaxJsonDepth are not counted. Any bytes.
int json_depth(std::string_view text);

/// is_discarded() if it is no JSON, or nests too deep. Json: nlohmann::json or nlohmann::ordered_json.
template <typename Json>
Json parsed_json(std::string_view text);

/// In one line, or with so many blanks a level; bytes that are no UTF-8 are replaced.
std::string json_text(const nlohmann::json& json, int indent = -1);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

/// Reads a truth value, a whole number or a text, if the value is one.
template <typename Json, typename Value>
bool read_value(const Json& json, Value& into) {
  const bool good = std::is_same_v<Value, bool>          ? json.is_boolean()
                    : std::is_same_v<Value, std::string> ? json.is_string()
                                                         : json.is_number_integer();
  if (good) into = json.template get<Value>();
  return good;
}

/// Of an object; absent, or of another kind than is wanted: the fallback.
template <typename Value, typename Json>
Value value_of(const Json& object, const char* key, Value fallback = {}) {
  if (const auto found = object.find(key); found != object.end()) read_value(*found, fallback);
  return fallback;
}

// An absent value in JSON is null. (So is a number that is not finite, by the library itself.)

template <typename T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace strobe::messages
