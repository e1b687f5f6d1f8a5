// JSON to and from text, compiled once for all that reads or writes it. What others wrote and nests deeper than any of ours
// is no JSON to us, since a value is copied and printed by recursion. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

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

}  // namespace strobe::messages
