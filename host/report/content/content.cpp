#include "host/report/content/content.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "host/config/notes.hpp"

namespace strobe::lab_report {

namespace {

using host::Shot;
using host::StoredSession;
using reduction::Record;

std::string note(const Record& record, const std::string& key) {
  const auto found = record.find(key);
  return found == record.end() ? std::string() : found->second;
}

bool has_a_number(const reduction::Readout& readout) {
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    if (readout.value[static_cast<reduction::Quantity>(i)]) return true;
  return false;
}

std::vector<ReportShot> shots_of(const std::vector<StoredSession>& sessions) {
  std::vector<ReportShot> shots;
  for (const StoredSession& session : sessions) {
    for (const Shot& shot : session.shots) {
      const std::string name = sessions.size() == 1 ? shot.name : folder_name(session) + ":" + shot.name;
      const bool counts = !shot.rejected && !shot.dry && has_a_number(shot.readout);
      shots.push_back({&session, &shot, name, counts});
    }
  }
  return shots;
}

int rank_of(const std::string& spin) {
  const std::array<std::string_view, 3> known{"zero", "top", "back"};
  return static_cast<int>(std::find(known.begin(), known.end(), spin) - known.begin());
}

std::string group_label(const std::string& spin, const std::string& angle) {
  if (spin.empty() && angle.empty()) return "condition not named";
  const std::string words = rank_of(spin) < 3 ? std::string(thesis::spin_phrase(spin)) : spin;
  if (angle.empty()) return words;
  return words.empty() ? angle + "°" : words + ", " + angle + "°";
}

std::string key_of(const std::string& spin, const std::string& angle) {
  if (spin.empty() && angle.empty()) return "unnamed";
  return spin + (spin.empty() || angle.empty() ? "" : "_") + angle;
}

void finish(ConditionGroup& group, const ReportInput& input) {
  for (const ReportShot& each : group.shots)
    if (each.counts) group.counted.push_back(each);
  group.summary = input.summarize(group.key, group.counted);
  group.summary.rejected = static_cast<int>(group.shots.size() - group.counted.size());
  std::vector<ReportShot> conforming;
  for (const ReportShot& each : group.counted)
    if (each.shot->readout.court_pace_conforming) conforming.push_back(each);
  if (!conforming.empty()) group.court_pace = input.summarize(group.key, conforming);
  if (input.thesis) group.thesis = input.thesis->used.condition(group.key);
}

std::vector<ConditionGroup> conditions_of(const std::vector<ReportShot>& shots, const ReportInput& input) {
  using Order = std::tuple<int, std::string, double, std::string>;
  std::map<Order, ConditionGroup> groups;
  for (const ReportShot& each : shots) {
    const Record& record = each.shot->readout.record;
    const std::string spin = note(record, "spin"), angle = note(record, "angle_deg");
    const double number =
        host::note_number(record, "angle_deg").value_or(std::numeric_limits<double>::infinity());
    ConditionGroup& group = groups[{rank_of(spin), spin, number, angle}];
    group.spin = spin;
    group.angle = angle;
    group.key = key_of(spin, angle);
    group.label = group_label(spin, angle);
    group.shots.push_back(each);
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

std::string folder_name(const StoredSession& session) {
  const auto name = session.folder.filename();
  return (name.empty() ? session.folder.parent_path().filename() : name).string();
}

Content content_of(const ReportInput& input) {
  Content content{.input = input,
                  .statements = input.statements,
                  .shots = shots_of(input.sessions),
                  .conditions = {},
                  .first_day = {},
                  .last_day = {}};
  for (const StoredSession& session : input.sessions)
    content.statements.insert(session.rig.statements.begin(), session.rig.statements.end());
  content.conditions = conditions_of(content.shots, input);
  set_days(content);
  return content;
}

}  // namespace strobe::lab_report
