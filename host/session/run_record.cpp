#include "host/session/run_record.hpp"

#include <fmt/format.h>

#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::host {
namespace {

using Json = nlohmann::ordered_json;

/// The keys of a record and where their values are, in the file's order.
template <typename Run, typename Visit>
void visit_fields(Run& run, const Visit& visit) {
  visit("utc", run.utc);
  visit("host_id", run.host_id);
  visit("version", run.version);
  visit("operator", run.operator_name);
  visit("shots", run.shots);
  visit("until", run.until);
  visit("retries", run.retries);
  visit("dry", run.dry);
  visit("notes", run.notes);
  visit("plan_file", run.plan_file);
  visit("spacing", run.spacing);
  visit("rig_file", run.rig_file);
  visit("photographs", run.photographs);
  visit("effort", run.effort);
  visit("key_fingerprint", run.key_fingerprint);
  visit("command", run.command);
  visit("session_shots", run.session_shots);
  visit("until_known", run.until_known);
  visit("protocol", run.protocol);
  visit("protocol_seed", run.protocol_seed);
}

void read_field(const Json& json, std::int64_t& host_id) {
  const std::string text = json.is_string() ? json.get<std::string>() : std::string();
  std::int64_t id = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), id);
  if (read.ec == std::errc() && read.ptr == text.data() + text.size()) host_id = id;
}

void read_field(const Json& json, reduction::Record& notes) {
  if (!json.is_object()) return;
  for (const auto& [key, value] : json.items())
    if (value.is_string()) notes[key] = value.get<std::string>();
}

void read_field(const Json& json, std::vector<std::string>& words) {
  if (!json.is_array()) return;
  for (const Json& word : json)
    if (word.is_string()) words.push_back(word.get<std::string>());
}

template <typename Value>
void read_field(const Json& json, Value& into) {
  messages::read_value(json, into);
}

std::optional<RunRecord> run_of(std::string_view line) {
  const Json object = messages::parsed_json<Json>(line);
  if (!object.is_object()) return std::nullopt;
  constexpr int kAbsent = std::numeric_limits<int>::min();
  RunRecord run;
  run.session_shots = kAbsent;
  visit_fields(run, [&object](const char* key, auto& into) {
    if (const auto found = object.find(key); found != object.end()) read_field(*found, into);
  });
  if (run.session_shots == kAbsent) run.session_shots = run.shots;
  return run.host_id == 0 ? std::nullopt : std::optional(run);
}

}  // namespace

std::string run_line(const RunRecord& run) {
  Json object;
  visit_fields(run, [&object](const char* key, const auto& value) { object[key] = value; });
  object["host_id"] = std::to_string(run.host_id);
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

Result<RunRecords> read_runs(const std::filesystem::path& path) {
  RunRecords records;
  int number = 0;
  const auto read =
      config::read_lines(path, [&](std::string_view line, bool) { records.add(line, ++number); });
  if (!read) return tl::unexpected(read.error());
  return records;
}

}  // namespace strobe::host
