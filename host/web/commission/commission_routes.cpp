#include "host/web/commission/commission_routes.hpp"

#include <chrono>
#include <utility>

#include "common/messages/parsed_json.hpp"
#include "host/commission/steps.hpp"

namespace strobe::web {
namespace {

using nlohmann::ordered_json;

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
    if (at_console_) return error_response(403, "only who stands at the rig can answer: at the console");
  }
  if (asked_.size() >= kMaxAsked) return error_response(503, "too much waits");
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
