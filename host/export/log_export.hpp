// An LCM log's messages as tables or JSON lines. Reads a log record by record, so that a log of any size
// takes the memory of one message, and goes on after damage. Reads files; one thread's.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <type_traits>
#include <vector>

#include "common/authentication/key.hpp"
#include "common/result.hpp"
#include "host/export/message_tables.hpp"

namespace strobe::host {

struct LogExportOptions {
  std::set<std::string> kinds;             ///< "EVENT", "SHOT" ...; empty: all
  std::optional<authentication::Key> key;  ///< with it each packet's seal is checked
};

/// What of a log could not be given.
struct LogExportRemains {
  std::int64_t messages = 0;       ///< that were given
  std::int64_t undecodable = 0;    ///< packets that are no message of this version
  std::int64_t damaged_bytes = 0;  ///< that are no record
  std::int64_t first_damage = -1;  ///< offset; -1: none
};

/// Hands over every row of every message. Columns before the message's own: log, record, logged_us, channel,
/// sealed_by (the key's fingerprint), verified. Fails with the file's name if it cannot be read.
Result<LogExportRemains> export_rows(const std::filesystem::path& log, const LogExportOptions& options,
                                     const TakeRow& take);

/// Hands over a line of JSON for every message: log, record, logged_us, channel, kind, sealed_by, verified,
/// message.
Result<LogExportRemains> export_json(const std::filesystem::path& log, const LogExportOptions& options,
                                     const std::function<void(const std::string&)>& take);

/// The logs of a session's folder by name: the hosts', or strobed's journals where there are none; of a file
/// itself. Fails if there are none.
Result<std::vector<std::filesystem::path>> logs_of(const std::filesystem::path& log_or_session);

// An LCM message as a JSON object, with its messages and lists in it. Absent numbers and instants are null;
// identifiers are texts, those of boots hexadecimal. Pure; thread-safe; allocates.

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
    return value == kNoTime_ns ? nlohmann::ordered_json() : nlohmann::ordered_json(value);
  }

  nlohmann::ordered_json object_;
};

}  // namespace strobe::host
