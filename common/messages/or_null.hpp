// An absent value in JSON is null. (So is a number that is not finite, by the library itself.)
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

namespace strobe::messages {

template <typename T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace strobe::messages
