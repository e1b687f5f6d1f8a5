#include "host/session/run_record.hpp"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

using Json = nlohmann::ordered_json;

/// Absent, or of another kind than is wanted: the fallback.
template <typename Value>
Value value_of(const Json& object, const char* key, Value fallback) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if constexpr (std::is_same_v<Value, bool>) return found->is_boolean() ? found->get<bool>() : fallback;
  if constexpr (std::is_same_v<Value, int>) return found->is_number_integer() ? found->get<int>() : fallback;
  if constexpr (std::is_same_v<Value, std::string>)
    return found->is_string() ? found->get<std::string>() : fallback;
}

std::int64_t host_id_of(const Json& object) {
  const std::string text = value_of(object, "host_id", std::string());
  std::int64_t id = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), id);
  return read.ec == std::errc() && read.ptr == text.data() + text.size() ? id : 0;
}

std::optional<RunRecord> run_of(std::string_view line) {
  const Json object = messages::parsed_json<Json>(line);
  if (!object.is_object()) return std::nullopt;
  RunRecord run;
  run.utc = value_of(object, "utc", std::string());
  run.host_id = host_id_of(object);
  run.version = value_of(object, "version", std::string());
  run.operator_name = value_of(object, "operator", std::string());
  run.shots = value_of(object, "shots", 1);
  run.until = value_of(object, "until", false);
  run.retries = value_of(object, "retries", 0);
  run.dry = value_of(object, "dry", false);
  const auto notes = object.find("notes");
  if (notes != object.end() && notes->is_object()) {
    for (const auto& [key, value] : notes->items())
      if (value.is_string()) run.notes[key] = value.get<std::string>();
  }
  run.plan_file = value_of(object, "plan_file", std::string());
  run.spacing = value_of(object, "spacing", std::string());
  run.rig_file = value_of(object, "rig_file", std::string());
  run.photographs = value_of(object, "photographs", std::string());
  run.effort = value_of(object, "effort", std::string());
  run.key_fingerprint = value_of(object, "key_fingerprint", std::string());
  run.session_shots = value_of(object, "session_shots", run.shots);
  const auto command = object.find("command");
  if (command != object.end() && command->is_array()) {
    for (const Json& word : *command)
      if (word.is_string()) run.command.push_back(word.get<std::string>());
  }
  return run.host_id == 0 ? std::nullopt : std::optional(run);
}

}  // namespace

std::string run_line(const RunRecord& run) {
  const Json object{{"utc", run.utc},
                    {"host_id", std::to_string(run.host_id)},
                    {"version", run.version},
                    {"operator", run.operator_name},
                    {"shots", run.shots},
                    {"until", run.until},
                    {"retries", run.retries},
                    {"dry", run.dry},
                    {"notes", run.notes},
                    {"plan_file", run.plan_file},
                    {"spacing", run.spacing},
                    {"rig_file", run.rig_file},
                    {"photographs", run.photographs},
                    {"effort", run.effort},
                    {"key_fingerprint", run.key_fingerprint},
                    {"command", run.command},
                    {"session_shots", run.session_shots}};
  // Words of a command line need not be text.
  return messages::json_text(object) + "\n";
}

void RunRecords::add(std::string_view line, int number) {
  if (line.find_first_not_of(" \t\r") == std::string_view::npos) return;
  if (auto run = run_of(line)) {
    runs.push_back(std::move(*run));
  } else {
    remarks.push_back(fmt::format("runs.jsonl:{}: not the record of a run; it is left out", number));
  }
}

RunRecords parse_runs(std::string_view text) {
  RunRecords records;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    records.add(text.substr(0, end), number);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return records;
}

Result<RunRecords> read_runs(const std::filesystem::path& path) {
  RunRecords records;
  int number = 0;
  const auto read =
      config::read_lines(path, [&](std::string_view line, bool) { records.add(line, ++number); });
  if (!read) return tl::unexpected(read.error());
  return records;
}

}  // namespace strobe::host
