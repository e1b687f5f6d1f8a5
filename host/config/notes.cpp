#include "host/config/notes.hpp"

#include <glib.h>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "common/messages/record.hpp"
#include "host/config/camera_table.hpp"

namespace strobe::host {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool valid_text(std::string_view text) {
  const bool utf8 = g_utf8_validate(text.data(), static_cast<gssize>(text.size()), nullptr) != FALSE;
  return utf8 && std::ranges::none_of(text, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

}  // namespace

std::optional<std::string> note_problem(std::string_view key, std::string_view value) {
  if (!messages::valid_note_key(key)) {
    return "note \"" + std::string(key) + "\": a key is 1 to 64 of a-z, 0-9, underscore and dot";
  }
  if (value.size() > messages::kLongestNoteValue)
    return "note " + std::string(key) + ": longer than 1024 bytes";
  if (!valid_text(value)) return "note " + std::string(key) + ": not plain UTF-8 text on one line";
  return std::nullopt;
}

Result<void> add_note(reduction::Record& record, std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) {
    return fail("note \"" + std::string(text) + "\": must be key=value");
  }
  const std::string key(trimmed(text.substr(0, equals)));
  const std::string value(trimmed(text.substr(equals + 1)));
  if (const auto problem = note_problem(key, value)) return fail(*problem);
  if (!record.contains(key) && record.size() >= messages::kMaxNotes)
    return fail("note " + key + ": more than 64 notes");
  record[key] = value;
  return {};
}

std::optional<double> note_number(const reduction::Record& record, std::string_view key) {
  const auto entry = record.find(std::string(key));
  if (entry == record.end()) return std::nullopt;
  const std::string_view text = trimmed(entry->second);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

namespace {

std::optional<std::string> text_problem(const std::string& text, bool is_day) {
  if (note_problem("text", text)) return "must be plain UTF-8 text of at most 1024 bytes on one line";
  if (is_day && !text.empty() && !days_since(text, WallTime{}))
    return "must be a date, such as 2026-11-21, not \"" + text + "\"";
  return std::nullopt;
}

std::string instrument_text(config::TomlTable& table, const char* key, bool is_day = false) {
  const std::string text = table.string_or(key, "");
  if (const auto problem = text_problem(text, is_day)) table.error_at(key, *problem);
  return text;
}

}  // namespace

std::optional<std::string> statement_problem(const StatementKey& key, const std::string& text) {
  return text_problem(text, key.id == "received" || key.id == "issued");
}

std::vector<Instrument> read_instruments(config::TomlTable report) {
  std::vector<Instrument> instruments;
  for (config::TomlTable& table : report.tables("instrument")) {
    Instrument each{instrument_text(table, "name"), instrument_text(table, "certificate"),
                    instrument_text(table, "calibrated", true), instrument_text(table, "due", true)};
    if (each.name.empty()) table.error_at("name", "must say which instrument it is");
    if (!each.due.empty() && each.due < each.calibrated)
      table.error_at("due", "must not be before the day of calibration");
    instruments.push_back(std::move(each));
  }
  return instruments;
}

Statements read_statements(config::TomlTable root) {
  Statements statements;
  config::TomlTable laboratory = root.table("laboratory");
  config::TomlTable report = root.table("report");
  for (const StatementKey& key : kStatementKeys) {
    config::TomlTable& table = key.table == "laboratory" ? laboratory : report;
    if (!table.has(key.key)) continue;
    const std::string text = table.string(key.key);
    if (const auto problem = statement_problem(key, text)) table.error_at(key.key, *problem);
    if (!text.empty()) statements[std::string(key.id)] = text;
  }
  return statements;
}

}  // namespace strobe::host
