#include "host/config/statements.hpp"

#include "host/config/camera_table.hpp"
#include "host/config/notes.hpp"

namespace strobe::host {

std::optional<std::string> statement_problem(const StatementKey& key, const std::string& text) {
  if (note_problem("text", text)) return "must be plain UTF-8 text of at most 1024 bytes on one line";
  const bool is_day = key.id == "received" || key.id == "issued";
  if (is_day && !text.empty() && !days_since(text, WallTime{}))
    return "must be a day as 2026-11-21, not \"" + text + "\"";
  return std::nullopt;
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
