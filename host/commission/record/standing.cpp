#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "host/commission/record/record.hpp"

namespace strobe::commission {
namespace {

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
  std::vector<std::string> failed, missing, changed, old, left_out;
  for (const Standing::Line& line : standing.lines) {
    if (line.step == nullptr) {
      missing.push_back(line.info.id);
    } else if (line.step->result.state == StepState::failed) {
      failed.push_back(line.info.id);
    } else if (line.changed) {
      changed.push_back(line.info.id);
    } else if (line.old) {
      old.push_back(line.info.id);
    } else if (line.step->result.state == StepState::skipped) {
      left_out.push_back(line.info.id);
    }
  }
  std::string text = fmt::format("commissioned on {}", standing.newest_utc.substr(0, 10));
  if (!failed.empty()) text += "; failed: " + list(failed);
  if (!changed.empty()) text += "; before the rig file's change: " + list(changed);
  if (!old.empty()) text += "; too old: " + list(old);
  if (!missing.empty()) text += "; never done: " + list(missing);
  if (!left_out.empty()) text += "; left out: " + list(left_out);
  return text;
}

}  // namespace

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
        line.step != nullptr && line.step->result.state != StepState::failed && !line.changed && !line.old;
    if (!well && result.state == Standing::State::good) result.state = Standing::State::doubtful;
    result.lines.push_back(std::move(line));
  }
  result.words = words_of(result);
  return result;
}

}  // namespace strobe::commission
