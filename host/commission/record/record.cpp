#include "host/commission/record/record.hpp"

#include <fmt/format.h>
#include <sodium.h>

// Without it a debug build ends where a person's file has [[ >]]: the parser asserts what it reports next.
#ifndef TOML_ASSERT
#define TOML_ASSERT(expr) static_assert(true)
#endif
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/config/files.hpp"
#include "common/config/toml_bounds.hpp"
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

Json json_of(const std::string& title, const StepResult& result) {
  Json figures = Json::object();
  for (const Figure& figure : result.figures) {
    Json& entry = figures[figure.name];
    entry["value"] = figure.value;
    if (figure.sd) entry["sd"] = *figure.sd;
    if (figure.expected) entry["expected"] = *figure.expected;
    if (figure.count > 0) entry["n"] = figure.count;
  }
  return {{"step", result.id},
          {"title", title},
          {"state", name(result.state)},
          {"value", messages::or_null(result.value)},
          {"sd", messages::or_null(result.sd)},
          {"unit", result.unit},
          {"limit", result.limit},
          {"words", result.words},
          {"advice", result.advice},
          {"fault", result.fault},
          {"figures", figures}};
}

std::optional<StepState> state_of(const std::string& word) {
  for (const StepState state :
       {StepState::passed, StepState::failed, StepState::skipped, StepState::not_told})
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

/// Of a UTC as the record has it; absent: it is none.
std::optional<double> days_since_utc(const std::string& utc, WallTime now) {
  const auto days = utc.size() >= 10 ? host::days_since(utc.substr(0, 10), now) : std::nullopt;
  return days ? std::optional(static_cast<double>(*days)) : std::nullopt;
}

std::string list(const std::vector<std::string>& ids) {
  std::string text;
  for (const std::string& id : ids) text += (text.empty() ? "" : ", ") + id;
  return text;
}

std::string words_of(const Standing& standing) {
  if (standing.state == Standing::State::absent) return "not commissioned";
  std::vector<std::string> failed, missing, changed, old, not_told, left_out;
  for (const Standing::Line& line : standing.lines) {
    if (line.step == nullptr) {
      missing.push_back(line.info.id);
    } else if (line.step->result.state == StepState::failed) {
      failed.push_back(line.info.id);
    } else if (line.changed) {
      changed.push_back(line.info.id);
    } else if (line.old) {
      old.push_back(line.info.id);
    } else if (line.step->result.state == StepState::not_told) {
      not_told.push_back(line.info.id);
    } else if (line.step->result.state == StepState::skipped) {
      left_out.push_back(line.info.id);
    }
  }
  std::string text = fmt::format("commissioned on {}", standing.newest_utc.substr(0, 10));
  if (!failed.empty()) text += "; failed: " + list(failed);
  if (!not_told.empty()) text += "; not told apart from the limit: " + list(not_told);
  if (!changed.empty()) text += "; before the rig file's change: " + list(changed);
  if (!old.empty()) text += "; too old: " + list(old);
  if (!missing.empty()) text += "; never done: " + list(missing);
  if (!left_out.empty()) text += "; left out: " + list(left_out);
  return text;
}

std::string sha256(std::string_view bytes) {
  std::array<unsigned char, crypto_hash_sha256_BYTES> hash{};
  crypto_hash_sha256(hash.data(), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  std::array<char, 2 * crypto_hash_sha256_BYTES + 1> text{};
  sodium_bin2hex(text.data(), text.size(), hash.data(), hash.size());
  return text.data();
}

}  // namespace

const RecordedStep* Record::newest(std::string_view id) const {
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    if (step->result.id == id) return &*step;
  return nullptr;
}

std::string record_line(const RecordedStep& step) {
  Json object{{"utc", step.utc}, {"rig", step.rig}};
  object.update(json_of(step.title, step.result));
  object["operator"] = step.operator_name;
  object["version"] = step.version;
  object["tables_hash"] = step.tables_hash;
  return messages::json_text(object) + "\n";
}

std::string result_json(const std::string& title, const StepResult& result) {
  return messages::json_text(json_of(title, result));
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

std::string tables_hash(const host::RigFile& rig, const std::vector<std::string>& tables) try {
  if (config::toml_bounds_problem(rig.text)) return {};
  const toml::table root = toml::parse(rig.text);
  std::ostringstream out;
  for (const std::string& name : tables) {
    out << '[' << name << "]\n";
    if (const toml::table* table = root[name].as_table()) out << toml::json_formatter(*table) << '\n';
    if (name == "camera") out << rig.calibration_text;
    if (name == "ball") out << rig.ball_text;
  }
  return sha256(out.str());
} catch (const toml::parse_error&) {
  return {};
}

Standing standing(const Record& record, std::span<const StepInfo> infos, const host::RigFile& rig,
                  WallTime now) {
  Standing result;
  if (!record.steps.empty()) result.state = Standing::State::good;
  for (const StepInfo& info : infos) {
    Standing::Line line{record.newest(info.id), info};
    if (line.step != nullptr) {
      const double days = days_since_utc(line.step->utc, now).value_or(1e9);
      line.changed = line.step->tables_hash != tables_hash(rig, info.tables);
      line.old = days > rig.commission.max_age_days;
      result.oldest_days = std::max(result.oldest_days, days);
      result.newest_utc = std::max(result.newest_utc, line.step->utc);
    }
    const bool well =
        line.step != nullptr && is_settled(line.step->result.state) && !line.changed && !line.old;
    if (!well && result.state == Standing::State::good) result.state = Standing::State::doubtful;
    result.lines.push_back(std::move(line));
  }
  result.words = words_of(result);
  return result;
}

}  // namespace strobe::commission
