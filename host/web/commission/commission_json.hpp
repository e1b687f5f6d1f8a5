// Commissioning as JSON: the record of a rig, or the run under way. Pure; thread-safe; allocates.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/commission/commissioning.hpp"
#include "host/commission/record/record.hpp"

namespace strobe::web {

/// {"running":false,"rig","utc","operator","age_days","max_age_days","standing","good","prompt":null,"waiting":"","steps":[…]}
nlohmann::ordered_json record_json(const commission::Record& record,
                                   std::span<const commission::StepInfo> infos, const host::RigFile& rig,
                                   WallTime now);

/// What a run shows of itself.
struct RunView {
  std::string rig, utc, operator_name;
  double max_age_days = 0.0;
  bool running = true;
  std::vector<commission::StepView> steps;
  std::optional<commission::Prompt> prompt;
  std::string prompted_step;  ///< its id
  std::string waiting;
};
/// Whether only who stands at the rig may answer: what makes outputs move, and what follows on it, seen or heard.
bool asks_at_console(const commission::Prompt& prompt);
/// As record_json(); "prompt" is {"step","kind","words","moves","at_console"} while a person is asked.
nlohmann::ordered_json run_json(const RunView& run);

}  // namespace strobe::web
