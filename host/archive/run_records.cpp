#include "host/archive/run_records.hpp"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <optional>

namespace strobe::host {
namespace {

using nlohmann::json;

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::int64_t> host_id_of(const json& object) {
  const std::string digits = text_of(object, "host_id");
  std::int64_t id = 0;
  const auto read = std::from_chars(digits.data(), digits.data() + digits.size(), id);
  if (read.ec != std::errc() || read.ptr != digits.data() + digits.size() || id == 0) return std::nullopt;
  return id;
}

std::optional<StoredRun> run_of(const json& object) {
  if (!object.is_object()) return std::nullopt;
  const auto host_id = host_id_of(object);
  if (!host_id) return std::nullopt;
  StoredRun run;
  run.host_id = *host_id;
  run.utc = text_of(object, "utc");
  run.version = text_of(object, "version");
  run.operator_name = text_of(object, "operator");
  run.plan_file = text_of(object, "plan_file");
  if (const auto shots = object.find("shots"); shots != object.end() && shots->is_number_integer())
    run.shots = shots->get<int>();
  if (const auto until = object.find("until"); until != object.end() && until->is_boolean())
    run.until = until->get<bool>();
  if (const auto notes = object.find("notes"); notes != object.end() && notes->is_object()) {
    for (const auto& [key, value] : notes->items())
      if (value.is_string()) run.notes[key] = value.get<std::string>();
  }
  if (const auto command = object.find("command"); command != object.end() && command->is_array()) {
    for (const json& word : *command)
      if (word.is_string()) run.command.push_back(word.get<std::string>());
  }
  return run;
}

}  // namespace

RunRecords parse_run_records(std::string_view text) {
  RunRecords records;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    const json object = json::parse(line, nullptr, false);
    if (auto run = run_of(object)) {
      records.runs.push_back(std::move(*run));
    } else {
      records.remarks.push_back(
          fmt::format("runs.jsonl:{}: not the record of a run; it is left out", number));
    }
  }
  return records;
}

}  // namespace strobe::host
