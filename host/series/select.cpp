#include "host/series/select.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <charconv>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "common/reduction/mixture.hpp"

namespace strobe::host {
namespace {

std::optional<double> as_number(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Numbers by size and before words, words by their bytes: an order whatever stands there.
struct ByValue {
  bool operator()(const std::string& a, const std::string& b) const {
    const auto x = as_number(a), y = as_number(b);
    if (x && y) return *x < *y;
    if (x.has_value() != y.has_value()) return x.has_value();
    return a < b;
  }
};

bool same_value(const std::string& a, const std::string& b) {
  const ByValue before;
  return !before(a, b) && !before(b, a);
}

bool named(const Shot& shot, const std::string& name) {
  return shot.full_name() == name || shot.name == name;
}

std::vector<const Shot*> pointers_to(const std::vector<Shot>& shots) {
  std::vector<const Shot*> out;
  for (const Shot& shot : shots) out.push_back(&shot);
  return out;
}

/// The one shot of that name.
Result<std::size_t> find_named(const std::vector<Shot>& shots, const std::string& name) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (shots[i].full_name() == name) return i;
    if (!named(shots[i], name)) continue;
    if (found)
      return fail("shot " + name + ": several sessions have one: " + shots[*found].full_name() + ", " +
                  shots[i].full_name());
    found = i;
  }
  if (!found) return fail("no shot " + name);
  return *found;
}

struct ByValues {
  bool operator()(const std::vector<std::string>& a, const std::vector<std::string>& b) const {
    return std::ranges::lexicographical_compare(a, b, ByValue());
  }
};

std::string group_title(const std::vector<std::string>& keys, const std::vector<std::string>& values) {
  std::string name;
  for (std::size_t i = 0; i < keys.size(); ++i)
    name += (i > 0 ? " " : "") + (values[i].empty() ? "(no " + keys[i] + ")" : values[i]);
  return name;
}

}  // namespace

std::string value_of(const Shot& shot, const std::string& key) {
  if (key == "session") return shot.session;
  if (key == "rig") return shot.rig ? shot.rig->rig : "";
  if (key == "calibration") return shot.calibration;
  if (key == "plan") return shot.plan;
  const auto note = shot.readout.record.find(key);
  return note == shot.readout.record.end() ? "" : note->second;
}

std::vector<std::string> differing_keys(const std::vector<const Shot*>& shots,
                                        const std::vector<std::string>& over) {
  std::vector<std::string> keys;
  for (const std::string_view key : kConditionKeys) {
    const std::string name(key);
    if (shots.empty() || std::ranges::find(over, name) != over.end()) continue;
    const std::string first = value_of(*shots.front(), name);
    if (!std::ranges::all_of(shots, [&](const Shot* s) { return same_value(value_of(*s, name), first); }))
      keys.push_back(name);
  }
  return keys;
}

std::string note_key(const std::string& word) { return word == "angle" ? "angle_deg" : word; }

Result<std::pair<std::string, std::string>> parse_where(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return fail("--where " + text + ": is not key=value, as spin=zero");
  return std::pair(note_key(text.substr(0, equals)), text.substr(equals + 1));
}

Result<SelectedShots> select_shots(std::vector<Shot> shots, const Selection& selection) {
  SelectedShots selected;
  std::vector<bool> left_out(shots.size(), false);
  for (const std::string& name : selection.without) {
    const auto found = find_named(shots, name);
    if (!found) return fail("--without: " + found.error().message);
    if (left_out[*found]) continue;
    left_out[*found] = true;
    selected.left_out.push_back(shots[*found].full_name());
  }
  std::vector<Shot> asked;
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (left_out[i]) continue;
    const bool named = std::ranges::all_of(selection.where, [&](const auto& condition) {
      return same_value(value_of(shots[i], condition.first), condition.second);
    });
    if (named)
      asked.push_back(std::move(shots[i]));
    else
      ++selected.other;
  }
  std::vector<std::string> keys, over;
  for (const std::string& word : selection.by) keys.push_back(note_key(word));
  for (const std::string& word : selection.over) over.push_back(note_key(word));
  if (keys.empty()) keys = differing_keys(pointers_to(asked), over);
  std::map<std::vector<std::string>, std::vector<Shot>, ByValues> groups;
  for (Shot& shot : asked) {
    std::vector<std::string> values;
    for (const std::string& key : keys) values.push_back(value_of(shot, key));
    groups[std::move(values)].push_back(std::move(shot));
  }
  for (auto& [values, members] : groups) {
    std::vector<std::string> mixed = differing_keys(pointers_to(members));
    selected.groups.push_back({group_title(keys, values), std::move(members), std::move(mixed)});
  }
  return selected;
}

namespace {

std::string text_of(const std::optional<double>& number) { return number ? fmt::format("{}", *number) : "-"; }

/// A calibration file is thousands of digits: shots keep a number that stands for it.
std::string calibration_of(const RigFile& rig) {
  const std::string text = fmt::format("{}\n{} {}", calibration_text(rig.camera),
                                       text_of(rig.analysis.px_per_m), text_of(rig.analysis.px_per_m_sd));
  return fmt::format("{:016x}", std::hash<std::string>{}(text));
}

/// Of a shot's plan what two plans of a person differ in.
std::string plan_of(const strobe_msgs::plan_t& plan) {
  return fmt::format("{:g} ms, open {:g} ms", 1e-6 * static_cast<double>(plan.period_ns),
                     1e-6 * static_cast<double>(plan.shutter_open_ns)) +
         (plan.train == plan.TRAIN_GATED
              ? fmt::format(", {} flashes {:g} ms after the gate", plan.flash_count,
                            1e-6 * static_cast<double>(plan.gate_delay_ns))
              : "");
}

std::string ball_of(const RigFile& rig, const reduction::Record& record) {
  const auto name = record.find("ball_name");
  return fmt::format("{}\n{} {} {}", name == record.end() ? "" : name->second, rig.ball.diameter_m,
                     rig.ball.diameter_sd_m, text_of(rig.ball.mass_kg));
}

}  // namespace

std::optional<reduction::Frame> matched_frame(const Shot& shot) {
  if (!shot.summary || shot.frame() == nullptr) return std::nullopt;
  AssembledShot assembled = assemble(*shot.summary, *shot.frame(), assembly_settings(*shot.rig));
  if (assembled.frame.images.empty()) return std::nullopt;
  return std::move(assembled.frame);
}

reduction::Budget budget_of(const Shot& shot) {
  const auto frame = matched_frame(shot);
  return frame ? reduction::mixture_budget(*frame, shot.readout) : reduction::Budget{};
}

Shot series_shot(const Shot& stored) {
  assert(stored.rig);
  Shot shot = stored;
  if (const auto frame = matched_frame(stored); frame && !shot.rejected) {
    shot.budget = reduction::mixture_budget(*frame, shot.readout);
    if (auto told = reduction::photograph_witnesses(*frame)) shot.witnesses = std::move(*told);
  }
  shot.calibration = calibration_of(*stored.rig);
  shot.ball = ball_of(*stored.rig, stored.readout.record);
  if (stored.summary) shot.plan = plan_of(stored.summary->plan);
  shot.summary.reset();
  shot.digitizations.clear();
  return shot;
}

std::vector<Shot> series_shots(const StoredSession& session, const std::string& session_name) {
  std::vector<Shot> shots;
  shots.reserve(session.shots.size());
  for (const Shot& stored : session.shots) shots.emplace_back(series_shot(stored)).session = session_name;
  return shots;
}

}  // namespace strobe::host
