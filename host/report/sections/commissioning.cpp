// The record of commissioning that each session keeps: every step's newest result, and how it stands on the day of the first
// test.
#include <fmt/format.h>

#include <chrono>

#include "host/commission/record/record.hpp"
#include "host/commission/steps.hpp"
#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

using commission::RecordedStep;
using commission::Standing;

/// Midnight of "2026-11-21"; the epoch if it is no day.
WallTime begin_of(const std::string& day) {
  const auto days = host::days_since(day, WallTime{});
  return WallTime{} - std::chrono::hours{24} * days.value_or(0);
}

std::string state_words(const Standing::Line& line) {
  if (line.step == nullptr) return "never done";
  std::string words(commission::name(line.step->result.state));
  if (line.changed) words += ", before the rig file's change";
  if (line.old) words += ", too old";
  return words;
}

Table steps_table(const Standing& stands, const std::string& key) {
  Table table{"steps" + key,
              "Steps",
              {{"step", "step", "", false},
               {"state", "state", "", false},
               {"day", "day", "", false},
               {"value", "value", ""},
               {"sd", "sd", ""},
               {"unit", "unit", "", false},
               {"limit", "limit", "", false},
               {"found", "what was found", "", false}},
              {},
              {}};
  for (const Standing::Line& line : stands.lines) {
    const RecordedStep* const step = line.step;
    Row row{{text_cell(line.info.title), text_cell(state_words(line))}};
    if (step == nullptr) {
      row.cells.resize(table.columns.size(), text_cell(""));
    } else {
      const auto& result = step->result;
      row.cells.push_back(text_cell(step->utc.substr(0, 10)));
      row.cells.push_back(number_cell(result.value, result.sd));
      row.cells.push_back(result.sd ? sd_cell(result.sd) : text_cell(""));
      for (const std::string& text : {result.unit, result.limit, result.words})
        row.cells.push_back(text_cell(text));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_session(Section& section, const host::StoredSession& session, const std::string& key,
                 const std::string& first_day) {
  const auto record = commission::read_record(session.folder / commission::kRecordInSession);
  const commission::Record kept = record ? *record : commission::Record{};
  const Standing stands =
      commission::standing(kept, commission::all_infos(), session.rig, begin_of(first_day));
  Facts facts{"commissioning" + key, "", {fact("folder", "Session's folder", folder_name(session))}};
  facts.facts.push_back(stated_fact("last_step", "Last step done", stands.newest_utc));
  if (!kept.steps.empty()) {
    facts.facts.push_back(stated_fact("operator", "By", kept.steps.back().operator_name));
    facts.facts.push_back(number_fact("oldest_days", "Oldest result before the first test",
                                      stands.oldest_days, fmt::format("{:.0f} days", stands.oldest_days)));
  }
  section.blocks.emplace_back(std::move(facts));
  section.blocks.emplace_back(Paragraph{"standing" + key,
                                        record ? "The rig is " + stands.words + "." : record.error().message,
                                        stands.state != Standing::State::good});
  if (stands.state != Standing::State::absent) section.blocks.emplace_back(steps_table(stands, key));
}

}  // namespace

Section commissioning(const Content& content) {
  Section section{"commissioning", "Commissioning", {}};
  int number = 0;
  for (const host::StoredSession& session : content.input.sessions)
    add_session(section, session, content.input.sessions.size() == 1 ? "" : fmt::format("_{}", ++number),
                content.first_day);
  return section;
}

}  // namespace strobe::lab_report
