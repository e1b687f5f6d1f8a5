// Which of a session's shots make a series: those of one condition, by the rule of host/series/select.hpp.
// Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/series/select.hpp"

namespace strobe::web {

/// What a person calls the condition of shots like this one: "zero 23°, acrylic, ITF type 2", and the values
/// of `differing` (host::kConditionKeys) besides. over: in which the shots differ themselves: ", over
/// operator".
std::string condition_words(const host::Shot& shot, const std::vector<std::string>& differing,
                            const std::vector<std::string>& over = {});

/// The shots in groups of one condition each. like: the name of a shot, whose condition alone is wanted;
/// empty: each. over: what they may differ in all the same. Fails where no shot has that name.
Result<std::vector<host::ShotGroup>> conditions_of(std::vector<host::Shot> shots, const std::string& like,
                                                   const std::vector<std::string>& over = {});

/// What the shots of all groups that count differ in; empty: one mean may be made of them.
std::vector<std::string> differences(const std::vector<host::ShotGroup>& groups);

/// Whether more than one group has shots that count.
bool is_mixture(const std::vector<host::ShotGroup>& groups);

/// [{"name","counted","like"}] of the groups with shots that count; like: the first one's name.
nlohmann::ordered_json conditions_json(const std::vector<host::ShotGroup>& groups,
                                       const std::vector<std::string>& differing);

}  // namespace strobe::web
