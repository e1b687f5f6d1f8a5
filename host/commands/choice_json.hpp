// The parts of a choice's JSON that `strobe predict` and `strobe reduce` share.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "common/frontier/frontier.hpp"

namespace strobe::host {

template <typename T>
nlohmann::ordered_json or_null(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// The method, its parameter, and what the measured frontier says of its error and cost.
nlohmann::ordered_json row_json(const frontier::Row& row);

}  // namespace strobe::host
