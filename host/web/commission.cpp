#include "host/web/commission.hpp"

#include <array>
#include <chrono>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "host/commission/steps.hpp"

namespace strobe::web {
namespace {

using commission::StepInfo;
using commission::StepResult;
using commission::StepState;
using nlohmann::ordered_json;

ordered_json step_json(const StepInfo& info, StepState state, const StepResult& found) {
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

/// In the order of Prompt::Kind.
constexpr std::array<std::string_view, 3> kPromptKinds{"begin", "question", "after_failure"};

ordered_json record_json(const commission::Record& record, std::span<const StepInfo> infos,
                         const host::RigFile& rig, WallTime now) {
  const commission::Standing stands = commission::standing(record, infos, rig, now);
  ordered_json steps = ordered_json::array();
  for (const auto& line : stands.lines) {
    ordered_json step = line.step == nullptr
                            ? step_json(line.info, StepState::pending, {})
                            : step_json(line.info, line.step->result.state, line.step->result);
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

ordered_json run_json(const RunView& run) {
  ordered_json steps = ordered_json::array();
  for (const auto& view : run.steps)
    steps.push_back(step_json(view.info, view.state, view.result.value_or(StepResult{})));
  ordered_json prompt;
  if (run.prompt)
    prompt = {{"step", run.prompted_step},
              {"kind", kPromptKinds[static_cast<std::size_t>(run.prompt->kind)]},
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

Response record_response(const std::filesystem::path& rig_path) {
  const auto rig = host::load_rig(rig_path.string());
  if (!rig) return error_response(422, rig.error().message);
  const auto record = rig_path.empty()
                          ? Result<commission::Record>(commission::Record{})
                          : commission::read_record(commission::record_path(rig_path, rig->commission));
  if (!record) return error_response(422, record.error().message);
  return json_response(record_json(*record, commission::all_infos(), *rig, std::chrono::system_clock::now()));
}

}  // namespace

bool asks_at_console(const commission::Prompt& prompt) {
  return prompt.moves || prompt.kind == commission::Prompt::Kind::question;
}

void add_record_route(Router& router, const std::filesystem::path& rig_path) {
  router.get("/api/v1/commission", Work::slow,
             [rig_path](const Request&) { return record_response(rig_path); });
}

void CommissionRun::show(const RunView& run) {
  std::string json = messages::json_text(run_json(run));
  {
    const std::lock_guard lock(mutex_);
    if (json == json_) return;
    json_ = json;
    prompted_ = run.prompt.has_value();
    at_console_ = run.prompt && asks_at_console(*run.prompt);
    prompted_step_ = run.prompted_step;
  }
  hub_.publish("commission", std::move(json));
}

std::vector<CommissionRun::Asked> CommissionRun::take_asked() {
  const std::lock_guard lock(mutex_);
  return std::exchange(asked_, {});
}

std::string CommissionRun::json() const {
  const std::lock_guard lock(mutex_);
  return json_;
}

Response CommissionRun::ask(const Request& request, Asked::Kind kind) {
  const ordered_json body = messages::parsed_json<ordered_json>(request.body);
  if (!body.is_object()) return error_response(400, "a JSON object is wanted");
  Asked asked{kind, "", request.from};
  if (kind == Asked::Kind::confirm) {
    const auto step = body.find("step");
    if (step == body.end() || !step->is_string())
      return error_response(400, "step: the id of the step is wanted");
    asked.step = step->get<std::string>();
  }
  const std::lock_guard lock(mutex_);
  if (kind == Asked::Kind::confirm) {
    if (!prompted_ || prompted_step_ != asked.step)
      return error_response(409, "this step does not ask for anything now");
    if (at_console_) return error_response(403, "only a person at the rig can answer: at the console");
  }
  if (asked_.size() >= kMaxAsked) return error_response(503, "too many requests wait: try again");
  asked_.push_back(std::move(asked));
  return json_text_response("{}");
}

void add_run_routes(Router& router, CommissionRun& run) {
  router.get("/api/v1/commission", Work::quick,
             [&run](const Request&) { return json_text_response(run.json()); });
  router.post("/api/v1/commission/confirm", Work::quick, [&run](const Request& request) {
    return run.ask(request, CommissionRun::Asked::Kind::confirm);
  });
  router.post("/api/v1/commission/more_time", Work::quick, [&run](const Request& request) {
    return run.ask(request, CommissionRun::Asked::Kind::more_time);
  });
}

}  // namespace strobe::web
