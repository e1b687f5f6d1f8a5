// An LCM message as a JSON object, with its messages and lists in it. Absent numbers and instants are null; identifiers
// are texts, those of boots hexadecimal. Pure; thread-safe; allocates.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <vector>

#include "host/export/message_rows.hpp"

namespace strobe::host {

class JsonVisitor {
 public:
  void field(const char* name, bool value, const char*) { object_[name] = value; }
  void field(const char* name, const std::string& value, const char*) { object_[name] = value; }
  void field(const char* name, double value, const char*) { object_[name] = json_of(value); }
  template <typename Integer>
  requires std::is_integral_v<Integer>
  void field(const char* name, Integer value, const char*) {
    const auto wide = static_cast<std::int64_t>(value);
    object_[name] = is_identifier(name) ? nlohmann::ordered_json(identifier_text(name, wide)) : json_of(wide);
  }

  template <typename Message>
  void part(const char* name, const Message& message) {
    object_[name] = object_of(message);
  }

  template <typename Element>
  void list(const char* name, const std::vector<Element>& elements) {
    nlohmann::ordered_json& array = object_[name] = nlohmann::ordered_json::array();
    for (const Element& element : elements) {
      if constexpr (std::is_class_v<Element> && !std::is_same_v<Element, std::string>)
        array.push_back(object_of(element));
      else
        array.push_back(element);
    }
  }

  template <typename Message>
  static nlohmann::ordered_json object_of(const Message& message) {
    JsonVisitor visitor;
    visitor.object_ = nlohmann::ordered_json::object();
    messages::visit_fields(message, visitor);
    return visitor.object_;
  }

 private:
  static nlohmann::ordered_json json_of(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  }
  static nlohmann::ordered_json json_of(std::int64_t value) {
    return value == kNoTime ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  }

  nlohmann::ordered_json object_;
};

}  // namespace strobe::host
