#include "host/report/content.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "host/config/notes.hpp"
#include "host/series/select.hpp"
#include "host/series/series.hpp"

namespace strobe::report {

namespace {

using host::Shot;
using host::StoredSession;
using reduction::Record;

constexpr std::array<std::string_view, 3> kSpins{"zero", "top", "back"};

std::string note(const Record& record, const std::string& key) {
  const auto found = record.find(key);
  return found == record.end() ? std::string() : found->second;
}

bool has_a_number(const reduction::Readout& readout) { return readout.value != reduction::Quantities{}; }

std::vector<ReportShot> shots_of(const std::vector<StoredSession>& sessions) {
  std::vector<ReportShot> shots;
  for (const StoredSession& session : sessions) {
    const std::string prefix = sessions.size() == 1 ? "" : folder_name(session);
    auto in_series = host::series_shots(session, prefix);  // in the session's order
    assert(in_series.size() == session.shots.size());
    for (std::size_t i = 0; i < session.shots.size(); ++i) {
      const host::Shot& shot = session.shots[i];
      const bool counts = !shot.rejected && !shot.dry && has_a_number(shot.readout);
      shots.push_back({&session, &shot, prefix.empty() ? shot.name : prefix + ":" + shot.name, counts,
                       std::make_shared<const host::Shot>(std::move(in_series[i]))});
    }
  }
  return shots;
}

/// After the known ones: 3.
int rank_of(const std::string& spin) {
  return static_cast<int>(std::ranges::find(kSpins, spin) - kSpins.begin());
}

void set_names(ConditionGroup& group, const std::string& spin, const std::string& angle) {
  const bool named = !spin.empty() || !angle.empty();
  const bool both = !spin.empty() && !angle.empty();
  group.spin = spin;
  group.angle = angle;
  group.spin_phrase = is_known_spin(spin) ? std::string(thesis::spin_phrase(spin)) : spin;
  group.key = named ? spin + (both ? "_" : "") + angle : "unnamed";
  group.label = named ? group.spin_phrase + (both ? ", " : "") + (angle.empty() ? "" : angle + "°")
                      : "condition not named";
}

host::SeriesSummary summary_of(const std::string& name, const std::vector<ReportShot>& shots) {
  std::vector<host::Shot> series;
  for (const ReportShot& each : shots) series.push_back(*each.in_series);
  return host::summarize(name, series);
}

void finish(ConditionGroup& group, const ReportInput& input) {
  std::vector<ReportShot> conforming;
  for (const ReportShot& each : group.shots) {
    if (!each.counts) continue;
    group.counted.push_back(each);
    if (each.shot->readout.court_pace_conforming) conforming.push_back(each);
  }
  group.summary = summary_of(group.key, group.counted);
  group.summary.rejected = static_cast<int>(group.shots.size() - group.counted.size());
  if (!conforming.empty()) group.court_pace = summary_of(group.key, conforming);
  if (input.thesis) group.thesis = input.thesis->used.condition(group.key);
}

std::vector<const Shot*> series_shots_of(const std::vector<ReportShot>& shots) {
  std::vector<const Shot*> out;
  for (const ReportShot& each : shots) out.push_back(each.in_series.get());
  return out;
}

/// "acrylic", "operator ann", "no operator".
std::string words_of(const std::string& key, const std::string& value) {
  const std::string what = key.substr(0, key.find("_name"));
  if (value.empty()) return "no " + what;
  if (what != key) return value;
  return what + " " + (key == "calibration" ? value.substr(0, 6) : value);
}

/// What the shots differ in besides spin and angle, which always divide.
std::vector<std::string> dividing_keys(const std::vector<ReportShot>& shots, std::vector<std::string> over) {
  over.insert(over.end(), {"spin", "angle_deg"});
  return host::differing_keys(series_shots_of(shots), over);
}

std::vector<ConditionGroup> conditions_of(const std::vector<ReportShot>& shots, const ReportInput& input) {
  using Order = std::tuple<int, std::string, double, std::string, std::vector<std::string>>;
  std::map<Order, ConditionGroup> groups;
  const std::vector<std::string> keys = dividing_keys(shots, input.over);
  for (const ReportShot& each : shots) {
    const Record& record = each.shot->readout.record;
    const std::string spin = note(record, "spin"), angle = note(record, "angle_deg");
    const double number =
        host::note_number(record, "angle_deg").value_or(std::numeric_limits<double>::infinity());
    std::vector<std::string> values;
    for (const std::string& key : keys) values.push_back(host::value_of(*each.in_series, key));
    ConditionGroup& group = groups[{rank_of(spin), spin, number, angle, values}];
    set_names(group, spin, angle);
    for (std::size_t i = 0; i < keys.size(); ++i) group.label += ", " + words_of(keys[i], values[i]);
    group.shots.push_back(each);
  }
  for (auto& [order, group] : groups) {
    group.mixed = dividing_keys(group.shots, {});
    for (const std::string& key : group.mixed) group.label += ", over " + key;
  }
  std::vector<ConditionGroup> out;
  std::map<std::string, int> used;  // names that a person gives may come to the same key
  for (auto& [order, group] : groups) {
    finish(group, input);
    if (const int before = used[group.key]++; before > 0) group.key += "_" + std::to_string(before + 1);
    out.push_back(std::move(group));
  }
  return out;
}

void set_days(Content& content) {
  for (const ReportShot& each : content.shots) {
    const std::string day = each.shot->utc.substr(0, 10);
    if (day.size() < 10) continue;
    if (content.first_day.empty() || day < content.first_day) content.first_day = day;
    content.last_day = std::max(content.last_day, day);
  }
}

}  // namespace

bool is_known_spin(const std::string& spin) { return rank_of(spin) < static_cast<int>(kSpins.size()); }

bool is_overdue(const host::Instrument& instrument, const Content& content) {
  return !instrument.due.empty() && instrument.due < content.last_day;
}

std::string folder_name(const StoredSession& session) {
  const auto whole = std::filesystem::absolute(session.folder).lexically_normal();
  return (whole.has_filename() ? whole : whole.parent_path()).filename().string();
}

std::vector<std::pair<const StoredSession*, std::string>> Content::sessions() const {
  std::vector<std::pair<const StoredSession*, std::string>> out;
  for (const StoredSession& session : input.sessions)
    out.emplace_back(&session, input.sessions.size() == 1 ? "" : "_" + std::to_string(out.size() + 1));
  return out;
}

Content content_of(const ReportInput& input) {
  Content content{.input = input, .statements = input.statements, .shots = shots_of(input.sessions)};
  for (const StoredSession& session : input.sessions)
    content.statements.insert(session.rig.statements.begin(), session.rig.statements.end());
  content.conditions = conditions_of(content.shots, input);
  set_days(content);
  return content;
}

}  // namespace strobe::report
