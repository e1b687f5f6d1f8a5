#include "host/web/conditions.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <nlohmann/json.hpp>

namespace strobe::web {
namespace {

bool counts(const host::Shot& shot) { return !shot.dry && !shot.rejected; }

std::string spin_and_angle(const host::Shot& shot) {
  const std::string spin = host::value_of(shot, "spin"), angle = host::value_of(shot, "angle_deg");
  if (angle.empty()) return spin;
  return (spin.empty() ? "" : spin + " ") + angle + "°";
}

bool has(const std::vector<std::string>& keys, std::string_view key) {
  return std::ranges::find(keys, key) != keys.end();
}

/// Of a key of the record: "ball", "surface angle", and the unit of its values.
std::pair<std::string, std::string> key_and_unit(std::string key) {
  std::string unit;
  for (const auto& [end, its_unit] : {std::pair{"_name", ""}, {"_deg", "°"}, {"_c", " °C"}}) {
    if (!key.ends_with(end)) continue;
    key.resize(key.size() - std::string_view(end).size());
    unit = its_unit;
  }
  std::ranges::replace(key, '_', ' ');
  return {key, unit};
}

bool names_itself(std::string_view key) { return key == "surface_name" || key == "ball_name"; }

/// "acrylic", "operator ann", "surface angle 3°", "no plan".
std::string words_of(const std::string& key, const std::string& value) {
  const auto [what, unit] = key_and_unit(key);
  if (value.empty()) return "no " + what;
  if (names_itself(key)) return value;
  constexpr std::size_t kShownOfCalibration = 6;
  return what + " " + (key == "calibration" ? value.substr(0, kShownOfCalibration) : value) + unit;
}

}  // namespace

std::string condition_words(const host::Shot& shot, const std::vector<std::string>& differing,
                            const std::vector<std::string>& over) {
  std::vector<std::string> parts;
  if (!has(over, "spin") && !has(over, "angle_deg")) parts.push_back(spin_and_angle(shot));
  for (const std::string_view each : host::kConditionKeys) {
    const std::string key(each), value = host::value_of(shot, key);
    if (has(over, key)) continue;
    const bool stands_there = (key == "spin" || key == "angle_deg") && !value.empty();
    if (!stands_there && (has(differing, key) || (names_itself(key) && !value.empty())))
      parts.push_back(words_of(key, value));
  }
  for (const std::string& key : over) parts.push_back("over " + key_and_unit(key).first);
  std::erase(parts, "");
  return fmt::format("{}", fmt::join(parts, ", "));
}

Result<std::vector<host::ShotGroup>> conditions_of(std::vector<host::Shot> shots, const std::string& like,
                                                   const std::vector<std::string>& over) {
  host::Selection selection;
  selection.over = over;
  if (!like.empty()) {
    const auto shot = std::ranges::find(shots, like, &host::Shot::name);
    if (shot == shots.end()) return fail("the series has no shot of this name");
    for (const std::string_view key : host::kConditionKeys)
      selection.where.emplace_back(key, host::value_of(*shot, std::string(key)));
  }
  auto selected = host::select_shots(std::move(shots), selection);
  if (!selected) return tl::unexpected(selected.error());
  return std::move(selected->groups);
}

std::vector<std::string> differences(const std::vector<host::ShotGroup>& groups) {
  std::vector<const host::Shot*> counted;
  for (const host::ShotGroup& group : groups)
    for (const host::Shot& shot : group.shots)
      if (counts(shot)) counted.push_back(&shot);
  return host::differing_keys(counted);
}

bool is_mixture(const std::vector<host::ShotGroup>& groups) {
  return std::ranges::count_if(groups, [](const host::ShotGroup& group) {
           return std::ranges::any_of(group.shots, counts);
         }) > 1;
}

nlohmann::ordered_json conditions_json(const std::vector<host::ShotGroup>& groups,
                                       const std::vector<std::string>& differing) {
  auto json = nlohmann::ordered_json::array();
  for (const host::ShotGroup& group : groups) {
    const auto first = std::ranges::find_if(group.shots, counts);
    if (first == group.shots.end()) continue;
    json.push_back({{"name", condition_words(*first, differing, group.mixed)},
                    {"counted", std::ranges::count_if(group.shots, counts)},
                    {"like", first->name}});
  }
  return json;
}

}  // namespace strobe::web
