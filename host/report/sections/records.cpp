// Versions, and hashes of the files that the report was made from.
#include <fmt/format.h>

#include <set>

#include "host/commission/record/record.hpp"
#include "host/report/model/hashes.hpp"
#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

namespace fs = std::filesystem;

void add_file(Table& table, const fs::path& folder, const fs::path& file, const char* what) {
  const auto hash = sha256_of_file(file);
  const fs::path shown = file.lexically_relative(folder);
  table.rows.push_back(
      {{text_cell(what), text_cell(shown.empty() ? file.filename().string() : shown.string()),
        text_cell(hash ? *hash : "cannot be read")}});
}

void add_text(Table& table, const std::string& text, const char* what, const std::string& name) {
  if (!text.empty()) table.rows.push_back({{text_cell(what), text_cell(name), text_cell(sha256_hex(text))}});
}

Table files_of(const host::StoredSession& session, const std::string& key) {
  Table table{"files" + key,
              "Files of " + folder_name(session),
              {{"what", "what", "", false}, {"file", "file", "", false}, {"sha256", "SHA-256", "", false}},
              {},
              {}};
  for (const fs::path& log : session.logs) add_file(table, session.folder, log, "log");
  add_text(table, session.rig.text, "rig file", "rig.toml");
  add_text(table, session.plan_text, "plan", "plan.toml");
  add_text(table, session.rig.calibration_text, "calibration",
           session.rig.camera.calibration.value_or("camera.toml"));
  std::error_code error;
  if (const fs::path record = session.folder / commission::kRecordInSession; fs::exists(record, error))
    add_file(table, session.folder, record, "record of commissioning");
  std::set<fs::path> known;
  for (const host::Shot& shot : session.shots) {
    const auto add_once = [&](const fs::path& file, const char* what) {
      const fs::path path = file.is_absolute() ? file : session.folder / file;
      if (!file.empty() && known.insert(path).second) add_file(table, session.folder, path, what);
    };
    if (shot.photograph) add_once(*shot.photograph, "photograph");
    for (const host::Digitization& each : shot.digitizations) {
      add_once(each.file, "digitization");
      add_once(each.corrections, "corrections");
    }
  }
  return table;
}

std::string versions(const host::StoredSession& session) {
  std::set<std::string> seen;
  for (const host::RunRecord& run : session.runs)
    if (!run.version.empty()) seen.insert(run.version);
  std::string out;
  for (const std::string& version : seen) out += (out.empty() ? "" : ", ") + version;
  return out;
}

}  // namespace

Section records(const Content& content) {
  Section section{"records", "Records", {}};
  Facts facts{"software", "", {fact("report", "This report by", "strobe " + content.input.version)}};
  int number = 0;
  for (const auto& session : content.input.sessions) {
    const std::string key = content.input.sessions.size() == 1 ? "" : fmt::format("_{}", ++number);
    facts.facts.push_back(stated_fact("fired" + key, "Shots fired by strobe", versions(session)));
    facts.facts.push_back(fact("seal" + key, "Seal",
                               session.verified ? "all messages are sealed with the laboratory's key"
                                                : "not all messages are sealed with the laboratory's key"));
  }
  section.blocks.emplace_back(std::move(facts));
  number = 0;
  for (const auto& session : content.input.sessions)
    section.blocks.emplace_back(
        files_of(session, content.input.sessions.size() == 1 ? "" : fmt::format("_{}", ++number)));
  return section;
}

}  // namespace strobe::lab_report
