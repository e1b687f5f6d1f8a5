#include "host/web/commission/commission_json.hpp"

#include "common/messages/parsed_json.hpp"

namespace strobe::web {
namespace {

using commission::StepInfo;
using commission::StepResult;
using commission::StepState;
using nlohmann::ordered_json;

ordered_json step_json(const StepInfo& info, StepState state, const StepResult* result) {
  static const StepResult kNone;
  const StepResult& found = result != nullptr ? *result : kNone;
  return {{"id", info.id},
          {"title", info.title},
          {"state", commission::name(state)},
          {"value", messages::or_null(found.value)},
          {"sd", messages::or_null(found.sd)},
          {"unit", found.unit},
          {"limit", found.limit},
          {"words", found.words},
          {"advice", found.advice},
          {"fault", found.fault}};
}

std::string_view name_of(commission::Prompt::Kind kind) {
  switch (kind) {
    case commission::Prompt::Kind::begin:
      return "begin";
    case commission::Prompt::Kind::question:
      return "question";
    case commission::Prompt::Kind::after_failure:
      return "after_failure";
  }
  return "";
}

}  // namespace

ordered_json record_json(const commission::Record& record, std::span<const StepInfo> infos,
                         const host::RigFile& rig, WallTime now) {
  const commission::Standing stands = commission::standing(record, infos, rig, now);
  ordered_json steps = ordered_json::array();
  for (const auto& line : stands.lines) {
    ordered_json step = line.step == nullptr
                            ? step_json(line.info, StepState::pending, nullptr)
                            : step_json(line.info, line.step->result.state, &line.step->result);
    step["utc"] = line.step == nullptr ? ordered_json() : ordered_json(line.step->utc);
    step["changed"] = line.changed;
    step["old"] = line.old;
    steps.push_back(std::move(step));
  }
  const bool any = stands.state != commission::Standing::State::absent;
  return {{"running", false},
          {"rig", rig.rig},
          {"utc", any ? ordered_json(stands.newest_utc) : ordered_json()},
          {"operator", any ? record.steps.back().operator_name : ""},
          {"age_days", any ? ordered_json(stands.oldest_days) : ordered_json()},
          {"max_age_days", rig.commission.max_age_days},
          {"standing", "the rig is " + stands.words},
          {"good", stands.state == commission::Standing::State::good},
          {"prompt", nullptr},
          {"waiting", ""},
          {"steps", any ? std::move(steps) : ordered_json::array()}};
}

bool asks_at_console(const commission::Prompt& prompt) {
  return prompt.moves || prompt.kind == commission::Prompt::Kind::question;
}

ordered_json run_json(const RunView& run) {
  ordered_json steps = ordered_json::array();
  for (const auto& view : run.steps)
    steps.push_back(step_json(view.info, view.state, view.result ? &*view.result : nullptr));
  ordered_json prompt;
  if (run.prompt)
    prompt = {{"step", run.prompted_step},
              {"kind", name_of(run.prompt->kind)},
              {"words", run.prompt->words},
              {"moves", run.prompt->moves},
              {"at_console", asks_at_console(*run.prompt)}};
  return {{"running", run.running},
          {"rig", run.rig},
          {"utc", run.utc},
          {"operator", run.operator_name},
          {"age_days", 0.0},
          {"max_age_days", run.max_age_days},
          {"standing", ""},
          {"good", false},
          {"prompt", std::move(prompt)},
          {"waiting", run.waiting},
          {"steps", std::move(steps)}};
}

}  // namespace strobe::web
