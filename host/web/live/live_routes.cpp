#include "host/web/live/live_routes.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "common/messages/parsed_json.hpp"

namespace strobe::web {
namespace {

/// The body of what asks for something to be done says nothing more.
bool is_empty_object(const std::string& body) {
  const auto json = messages::parsed_json<nlohmann::json>(body);
  return json.is_object() && json.empty();
}

Response ask(LiveState& state, const Request& request, LiveCommand::Kind kind, const char* cannot) {
  if (!is_empty_object(request.body)) return error_response(400, "the body must be {}");
  switch (state.ask({kind, request.from})) {
    case LiveState::Asked::taken:
      return json_response({{"asked", true}}, 202);
    case LiveState::Asked::waits:
      return error_response(503, "the host has not taken it within a second");
    case LiveState::Asked::no:
      return error_response(409, cannot);
    case LiveState::Asked::too_often:
      break;
  }
  return error_response(503, "the host has not taken what it was asked before");
}

}  // namespace

void add_live_routes(Router& router, LiveState& state) {
  router.get("/api/v1/live", Work::quick,
             [&state](const Request&) { return json_text_response(state.live_json()); });
  router.get("/api/v1/timing", Work::quick, [&state](const Request&) {
    auto timing = state.timing_json();
    return timing ? json_text_response(std::move(*timing)) : error_response(404, "no firmware was heard yet");
  });
  router.post("/api/v1/stop", Work::waits, [&state](const Request& request) {
    return ask(state, request, LiveCommand::Kind::stop, "there is no series to be ended");
  });
  router.post("/api/v1/disarm", Work::waits, [&state](const Request& request) {
    return ask(state, request, LiveCommand::Kind::disarm, "without the lab's key nothing can be disarmed");
  });
}

}  // namespace strobe::web
