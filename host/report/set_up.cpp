// What stood on the bench and what proves it: rig, ball, camera, runs; the record of commissioning, every
// step's newest result and how it stands on the day of the first test; versions, and hashes of the files that
// the report was made from.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "host/commission/record/record.hpp"
#include "host/commission/steps.hpp"
#include "host/report/hashes.hpp"
#include "host/report/sections.hpp"

namespace strobe::report {

namespace {

namespace fs = std::filesystem;
using commission::RecordedStep;
using commission::Standing;
using host::CameraTable;
using host::StoredSession;

std::string number_text(const std::optional<double>& value, int digits, const char* unit) {
  return value ? fmt::format("{:.{}g}{}", *value, digits, unit) : std::string();
}

std::string with_sd(double value, const std::optional<double>& sd, const char* unit) {
  if (!sd) return fmt::format("{:.4g}{}, sd not stated", value, unit);
  if (*sd > 0.0) return expanded_cell(value, sd).text + unit;
  return fmt::format("{:.7g}{}, taken as exact", value, unit);
}

/// Which scale the shots were measured with: a calibration's supersedes that of [analysis].
bool camera_gives_scale(const StoredSession& session) {
  const auto& camera = session.rig.camera;
  return camera.px_per_m && (camera.px_per_m_sd || !session.rig.analysis.px_per_m);
}

Facts rig_facts(const StoredSession& session, const std::string& key) {
  const auto& ball = session.rig.ball;
  const auto& analysis = session.rig.analysis;
  const auto& plan = session.rig.plan;
  Facts facts{
      "rig" + key,
      "Rig and ball",
      {fact("rig", "Rig", session.rig.rig), fact("folder", "Session's folder", folder_name(session)),
       number_fact("ball_diameter_m", "Ball's diameter", ball.diameter_m,
                   with_sd(1e3 * ball.diameter_m, 1e3 * ball.diameter_sd_m, " mm (sd of its tolerance)")),
       stated_fact("ball_mass_kg", "Ball's mass",
                   number_text(ball.mass_kg ? std::optional(1e3 * *ball.mass_kg) : std::nullopt, 4, " g")),
       stated_fact("surface_angle_deg", "Inclination of the surface",
                   number_text(analysis.surface_angle_deg, 4, " degrees")),
       fact("flash_period", "Shortest interval of flashes in the rig's plan",
            fmt::format("{:.3f} ms", 1e-6 * static_cast<double>(plan.even.period.count()))),
       fact("spacing", "Intervals of flashes", plan.spacing == host::Spacing::coded ? "coded" : "even")}};
  if (ball.kind) facts.facts.insert(facts.facts.begin() + 2, fact("ball_kind", "Ball", ball.kind->title));
  return facts;
}

std::string age(const CameraTable& camera, const std::string& day) {
  if (!camera.calibrated || day.size() != 10) return {};
  const auto then = host::days_since(*camera.calibrated, WallTime{}),
             tested = host::days_since(day, WallTime{});
  if (!then || !tested) return {};
  const auto days = *then - *tested;
  const bool is_old = static_cast<double>(days) > camera.max_age_days;
  return fmt::format("{} days before the first test{}", days,
                     is_old ? ": older than the rig's max_age_days" : "");
}

Facts camera_facts(const StoredSession& session, const std::string& key, const std::string& first_day) {
  const CameraTable& camera = session.rig.camera;
  const auto& analysis = session.rig.analysis;
  const bool by_camera = camera_gives_scale(session);
  const auto scale = by_camera ? camera.px_per_m : analysis.px_per_m;
  const auto sd = by_camera ? camera.px_per_m_sd : analysis.px_per_m_sd;
  Fact of_scale = stated_fact("px_per_m", "Scale in the balls' plane",
                              scale ? with_sd(*scale, sd, " px/m") : std::string());
  of_scale.number = scale;
  if (scale && !sd) of_scale.text += " (a first guess, refined on each photograph by the ball's diameter)";
  std::vector<Fact> facts{stated_fact("calibrated", "Calibrated on", camera.calibrated.value_or(""))};
  if (const std::string words = age(camera, first_day); !words.empty())
    facts.push_back(fact("calibration_age", "Age of the calibration", words));
  facts.insert(facts.end(), {std::move(of_scale),
                             stated_fact("residual_px", "Residual of the calibration, rms",
                                         number_text(camera.residual_px, 2, " px")),
                             stated_fact("tilt_deg", "Tilt of the optical axis",
                                         number_text(camera.tilt_deg, 2, " degrees")),
                             stated_fact("board", "Board", camera.board.value_or("")),
                             stated_fact("photographs", "Photographs of the board",
                                         camera.photographs ? fmt::format("{}", *camera.photographs) : "")});
  if (camera.width_px && camera.height_px)
    facts.push_back(fact("size_px", "Size of photographs",
                         fmt::format("{} x {} px", *camera.width_px, *camera.height_px)));
  return {"camera" + key, "Camera", std::move(facts)};
}

/// How its calibration stands in the days of the tests.
std::string instrument_state(const host::Instrument& instrument, const Content& content) {
  if (instrument.calibrated.empty()) return "not stated";
  if (!content.first_day.empty() && instrument.calibrated > content.first_day)
    return "calibrated after the tests began";
  if (is_overdue(instrument, content)) return "overdue";
  return instrument.due.empty() ? "calibrated before" : "in force";
}

void add_instruments(Section& section, const StoredSession& session, const std::string& key,
                     const Content& content) {
  Table table{
      "instruments" + key,
      "Instruments",
      {text_column("instrument"), text_column("certificate"), text_column("calibrated", "calibrated on"),
       text_column("due", "due on"), text_column("state", "in the tests")}};
  const auto stated = [](const std::string& text) { return text.empty() ? "not stated" : text; };
  for (const host::Instrument& each : session.rig.instruments)
    table.rows.push_back({{each.name, stated(each.certificate), stated(each.calibrated), stated(each.due),
                           instrument_state(each, content)}});
  if (table.rows.empty())
    section.blocks.emplace_back(
        Facts{"instruments" + key, "", {stated_fact("instruments", "Instruments and certificates", "")}});
  else
    section.blocks.emplace_back(std::move(table));
}

Table runs_table(const StoredSession& session, const std::string& key) {
  Table table{
      "runs" + key,
      "Runs",
      {text_column("utc", "begun (UTC)"), text_column("operator", "started by"),
       text_column("version", "strobe"), number_column("shots", "shots asked for"), text_column("notes")}};
  for (const host::RunRecord& run : session.runs) {
    std::string notes;
    for (const auto& [name, value] : run.notes) append(notes, name + " " + value, "; ");
    table.rows.push_back({{run.utc, run.operator_name, run.version, count_cell(run.shots), notes}});
  }
  return table;
}

/// Where a comment begins: not within "quotes" or 'quotes' of one line.
std::size_t comment_begin(const std::string& line) {
  char quote = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (quote == '"' && line[i] == '\\')
      ++i;
    else if (quote != 0)
      quote = line[i] == quote ? 0 : quote;
    else if (line[i] == '#')
      return i;
    else if (line[i] == '"' || line[i] == '\'')
      quote = line[i];
  }
  return line.size();
}

/// Without comments and empty lines. without_scale: without [analysis] px_per_m and px_per_m_sd.
std::string essence(const std::string& text, bool without_scale = false) {
  std::string out, table;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    std::string line = text.substr(from, end - from);
    line.resize(comment_begin(line));
    line.resize(line.find_last_not_of(" \t\r") + 1);
    from = end + 1;
    if (line.starts_with("[")) table = line;
    const bool is_scale = table == "[analysis]" && line.starts_with("px_per_m");
    if (!line.empty() && !(without_scale && is_scale)) out += line + "\n";
  }
  return out;
}

/// Midnight of "2026-11-21"; the epoch if it is no day.
WallTime begin_of(const std::string& day) {
  const auto days = host::days_since(day, WallTime{});
  return WallTime{} - std::chrono::hours{24} * days.value_or(0);
}

std::string state_words(const Standing::Line& line) {
  if (line.step == nullptr) return "never done";
  std::string words(commission::in_words(line.step->result.state));
  if (line.changed) words += ", before the rig file's change";
  if (line.old) words += ", too old";
  return words;
}

Table steps_table(const Standing& stands, const std::string& key) {
  Table table{"steps" + key,
              "Steps",
              {text_column("step"), text_column("state"), text_column("day"), number_column("value"),
               number_column("sd"), text_column("unit"), text_column("limit"),
               text_column("found", "what was found")}};
  for (const Standing::Line& line : stands.lines) {
    Row row{{line.info.title, state_words(line)}};
    if (line.step == nullptr) {
      row.cells.resize(table.columns.size(), "");
    } else {
      const auto& result = line.step->result;
      row.cells.insert(row.cells.end(),
                       {line.step->utc.substr(0, 10), number_cell(result.value, result.sd),
                        result.sd ? sd_cell(result.sd) : "", result.unit, result.limit, result.words});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

void add_session(Section& section, const StoredSession& session, const std::string& key,
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
  section.blocks.emplace_back(
      Paragraph{"standing" + key,
                record ? "The rig is " + stands.words + "." : "The record of commissioning cannot be read.",
                stands.state != Standing::State::good});
  if (stands.state != Standing::State::absent) section.blocks.emplace_back(steps_table(stands, key));
}

void add_file(Table& table, const fs::path& folder, const fs::path& file, const char* what) {
  const auto hash = sha256_of_file(file);
  const fs::path shown = file.lexically_relative(folder);
  table.rows.push_back(
      {{what, shown.empty() ? file.filename().string() : shown.string(), hash ? *hash : "cannot be read"}});
}

void add_text(Table& table, const std::string& text, const char* what, const std::string& name) {
  if (!text.empty()) table.rows.push_back({{what, name, sha256_hex(text)}});
}

Table files_of(const StoredSession& session, const std::string& key) {
  Table table{"files" + key,
              "Files of " + folder_name(session),
              {text_column("what"), text_column("file"), text_column("sha256", "SHA-256")}};
  for (const fs::path& log : session.logs) add_file(table, session.folder, log, "log");
  add_text(table, session.rig.text, "rig file", "rig.toml");
  add_text(table, session.plan_text, "plan", "plan.toml");
  add_text(table, session.rig.calibration_text, "calibration",
           session.rig.camera.calibration.value_or("camera.toml"));
  add_text(table, session.rig.ball_text, "ball", host::kept_ball_file(session.rig.ball));
  std::error_code error;
  if (const fs::path record = session.folder / commission::kRecordInSession; fs::exists(record, error))
    add_file(table, session.folder, record, "record of commissioning");
  std::set<fs::path> known;
  for (const host::Shot& shot : session.shots) {
    const auto add_once = [&](const fs::path& file, const char* what) {
      if (!file.empty() && known.insert(file).second) add_file(table, session.folder, file, what);
    };
    if (shot.photograph) add_once(*shot.photograph, "photograph");
    for (const host::Digitization& each : shot.digitizations) {
      add_once(each.file, "digitization");
      add_once(each.corrections, "corrections");
    }
  }
  return table;
}

std::string versions(const StoredSession& session) {
  std::set<std::string> seen;
  for (const host::RunRecord& run : session.runs)
    if (!run.version.empty()) seen.insert(run.version);
  std::string out;
  for (const std::string& version : seen) append(out, version);
  return out;
}

}  // namespace

Section set_up(const Content& content) {
  Section section{"set_up", "Set-up and calibration"};
  for (const auto& [session, key] : content.sessions()) {
    section.blocks.emplace_back(rig_facts(*session, key));
    section.blocks.emplace_back(camera_facts(*session, key, content.first_day));
    add_instruments(section, *session, key, content);
    if (Table runs = runs_table(*session, key); !runs.rows.empty())
      section.blocks.emplace_back(std::move(runs));
    const bool superseded = camera_gives_scale(*session) && session->rig.analysis.px_per_m;
    section.blocks.emplace_back(Listing{"rig_file" + key,
                                        superseded
                                            ? "Rig file as used, without comments and the scale that the "
                                              "calibration supersedes"
                                            : "Rig file as used, without comments",
                                        essence(session->rig.text, superseded)});
    if (!session->plan_text.empty())
      section.blocks.emplace_back(Listing{"plan_file" + key, "Plan as used", essence(session->plan_text)});
  }
  return section;
}

Section commissioning(const Content& content) {
  Section section{"commissioning", "Commissioning"};
  for (const auto& [session, key] : content.sessions())
    add_session(section, *session, key, content.first_day);
  return section;
}

Section records(const Content& content) {
  Facts software{"software", "", {fact("report", "This report by", "strobe " + content.input.version)}};
  std::vector<Table> files;
  for (const auto& [session, key] : content.sessions()) {
    software.facts.push_back(stated_fact("fired" + key, "Shots fired by strobe", versions(*session)));
    software.facts.push_back(fact("seal" + key, "Seal",
                                  session->verified
                                      ? "all messages are sealed with the laboratory's key"
                                      : "not all messages are sealed with the laboratory's key"));
    files.push_back(files_of(*session, key));
  }
  Section section{"records", "Records", {std::move(software)}};
  for (Table& table : files) section.blocks.emplace_back(std::move(table));
  return section;
}

}  // namespace strobe::report
