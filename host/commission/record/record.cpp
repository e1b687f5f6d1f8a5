#include "host/commission/record/record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/messages/or_null.hpp"
#include "common/messages/parsed_json.hpp"

namespace strobe::commission {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<double> number_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? std::optional(found->get<double>()) : std::nullopt;
}

std::vector<Figure> figures_of(const Json& object) {
  std::vector<Figure> figures;
  const auto found = object.find("figures");
  if (found == object.end() || !found->is_object()) return figures;
  for (const auto& [key, entry] : found->items()) {
    const auto value = entry.is_object() ? number_of(entry, "value") : std::nullopt;
    if (!value) continue;
    figures.push_back({key, *value, number_of(entry, "sd"), number_of(entry, "expected"),
                       static_cast<int>(std::clamp(number_of(entry, "n").value_or(0.0), 0.0, 1e9))});
  }
  return figures;
}

std::optional<StepState> state_of(const std::string& word) {
  for (const StepState state : {StepState::passed, StepState::failed, StepState::skipped})
    if (name(state) == word) return state;
  return std::nullopt;
}

std::optional<RecordedStep> step_of(std::string_view line) {
  const Json object = messages::parsed_json<Json>(line);
  if (!object.is_object()) return std::nullopt;
  RecordedStep step;
  const auto state = state_of(text_of(object, "state"));
  step.result.id = text_of(object, "step");
  step.utc = text_of(object, "utc");
  if (!state || step.result.id.empty() || step.utc.empty()) return std::nullopt;
  step.operator_name = text_of(object, "operator");
  step.version = text_of(object, "version");
  step.rig = text_of(object, "rig");
  step.tables_hash = text_of(object, "tables_hash");
  step.title = text_of(object, "title");
  step.result.state = *state;
  step.result.value = number_of(object, "value");
  step.result.sd = number_of(object, "sd");
  step.result.unit = text_of(object, "unit");
  step.result.limit = text_of(object, "limit");
  step.result.words = text_of(object, "words");
  step.result.advice = text_of(object, "advice");
  step.result.fault = text_of(object, "fault");
  step.result.figures = figures_of(object);
  return step;
}

}  // namespace

const RecordedStep* Record::newest(std::string_view id) const {
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    if (step->result.id == id) return &*step;
  return nullptr;
}

std::string record_line(const RecordedStep& step) {
  const StepResult& result = step.result;
  Json figures = Json::object();
  for (const Figure& figure : result.figures) {
    Json& entry = figures[figure.name];
    entry["value"] = figure.value;
    if (figure.sd) entry["sd"] = *figure.sd;
    if (figure.expected) entry["expected"] = *figure.expected;
    if (figure.count > 0) entry["n"] = figure.count;
  }
  const Json object{{"utc", step.utc},
                    {"rig", step.rig},
                    {"step", result.id},
                    {"title", step.title},
                    {"state", name(result.state)},
                    {"value", messages::or_null(result.value)},
                    {"sd", messages::or_null(result.sd)},
                    {"unit", result.unit},
                    {"limit", result.limit},
                    {"words", result.words},
                    {"advice", result.advice},
                    {"fault", result.fault},
                    {"figures", figures},
                    {"operator", step.operator_name},
                    {"version", step.version},
                    {"tables_hash", step.tables_hash}};
  return messages::json_text(object) + "\n";
}

Record parse_record(std::string_view text) {
  Record record;
  record.torn = !text.empty() && text.back() != '\n';
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    if (auto step = step_of(line)) {
      record.steps.push_back(std::move(*step));
    } else {
      record.remarks.push_back(
          fmt::format("line {} of the record of commissioning is no step; it is left out", number));
    }
  }
  return record;
}

Result<Record> read_record(const std::filesystem::path& path) {
  const auto text = config::read_file_if_any(path);
  if (!text) return tl::unexpected(text.error());
  return *text ? parse_record(**text) : Record{};
}

std::filesystem::path record_path(const std::filesystem::path& rig_path,
                                  const host::CommissionTable& settings) {
  if (settings.record) return rig_path.parent_path() / *settings.record;
  std::filesystem::path path = rig_path;
  return path.replace_extension(".commission.jsonl");
}

}  // namespace strobe::commission
