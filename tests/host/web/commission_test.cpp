// Commissioning over HTTP: what is shown, and that nothing that moves can be confirmed there.
#include "host/web/commission.hpp"

#include <string>

#include "tests/host/web/documented.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::web;
using commission::Prompt;
using commission::StepState;
using nlohmann::ordered_json;

ordered_json body_of(const Response& response) { return ordered_json::parse(*response.body); }

}  // namespace

TEST_GROUP(CommissionRoutes) {
  testing::TemporaryFolder folder;
  EventHub hub;
  CommissionRun run{hub};
  Router router;

  Response ask(const char* method, const char* path, const std::string& body = "") {
    Request request;
    request.method = method;
    request.path = path;
    request.body = body;
    request.from = "127.0.0.1";
    return router.route(request);
  }
  RunView prompted(bool moves) {
    RunView view;
    view.rig = "bench";
    view.steps = {{{"key", "key", {}}, {}, StepState::waiting, std::nullopt}};
    view.prompt = Prompt{Prompt::Kind::begin, "does <b>it</b>", moves};
    view.prompted_step = "key";
    return view;
  }
};

TEST(CommissionRoutes, AnswerWithTheRunAndTellViewers) {
  add_run_routes(router, run);
  run.show(prompted(false));
  const ordered_json shown = body_of(ask("GET", "/api/v1/commission"));
  CHECK_TRUE(shown["running"].get<bool>());
  CHECK_EQUAL("waiting", shown["steps"][0]["state"].get<std::string>());
  CHECK_TRUE(shown["steps"][0]["value"].is_null());
  CHECK_EQUAL("does <b>it</b>", shown["prompt"]["words"].get<std::string>());
  const std::int64_t told = hub.last_id();
  run.show(prompted(false));
  CHECK_EQUAL(told, hub.last_id());  // nothing new
}

TEST(CommissionRoutes, ConfirmWhatWatchesInputsAlone) {
  add_run_routes(router, run);
  run.show(prompted(false));
  LONGS_EQUAL(200, ask("POST", "/api/v1/commission/confirm", R"({"step":"key"})").status);
  const auto asked = run.take_asked();
  LONGS_EQUAL(1, asked.size());
  CHECK_EQUAL("key", asked[0].step);
  LONGS_EQUAL(0, run.take_asked().size());
}

TEST(CommissionRoutes, NeverConfirmWhatMoves) {
  add_run_routes(router, run);
  run.show(prompted(true));
  LONGS_EQUAL(403, ask("POST", "/api/v1/commission/confirm", R"({"step":"key"})").status);
  LONGS_EQUAL(0, run.take_asked().size());
}

/// "Did the trigger click exactly once?" is for whoever heard it.
TEST(CommissionRoutes, NeverAnswerAQuestion) {
  add_run_routes(router, run);
  RunView view = prompted(false);
  view.prompt->kind = Prompt::Kind::question;
  run.show(view);
  CHECK_TRUE(body_of(ask("GET", "/api/v1/commission"))["prompt"]["at_console"].get<bool>());
  LONGS_EQUAL(403, ask("POST", "/api/v1/commission/confirm", R"({"step":"key"})").status);
  LONGS_EQUAL(0, run.take_asked().size());
  view.prompt->kind = Prompt::Kind::after_failure;
  run.show(view);
  CHECK_FALSE(body_of(ask("GET", "/api/v1/commission"))["prompt"]["at_console"].get<bool>());
  LONGS_EQUAL(200, ask("POST", "/api/v1/commission/confirm", R"({"step":"key"})").status);
}

TEST(CommissionRoutes, RefuseWhatIsNotAskedForOrNotUnderstood) {
  add_run_routes(router, run);
  LONGS_EQUAL(409, ask("POST", "/api/v1/commission/confirm", R"({"step":"key"})").status);
  run.show(prompted(false));
  LONGS_EQUAL(409, ask("POST", "/api/v1/commission/confirm", R"({"step":"estop"})").status);
  for (const char* const body : {"", "[]", "{}", R"({"step":7})", "{\"step\":\"k"})
    LONGS_EQUAL(400, ask("POST", "/api/v1/commission/confirm", body).status);
  for (int i = 0; i < 30; ++i) ask("POST", "/api/v1/commission/more_time", "{}");
  LONGS_EQUAL(503, ask("POST", "/api/v1/commission/more_time", "{}").status);
  LONGS_EQUAL(16, run.take_asked().size());
}

TEST(CommissionRoutes, AnswerWithTheRecordWhereNothingRuns) {
  testing::write_text(folder / "rig.toml", "rig = \"bench\"\n[lamps]\ndelay_us = 12.0\n");
  add_record_route(router, folder / "rig.toml");
  ordered_json shown = body_of(ask("GET", "/api/v1/commission"));
  CHECK_EQUAL("the rig is not commissioned", shown["standing"].get<std::string>());
  CHECK_EQUAL(std::size_t{0}, shown["steps"].size());
  commission::RecordedStep step{"2026-11-20T10:00:00.000Z", "a@b", "1", "bench", "", "lamp A alone", {}};
  step.result.id = "lamp_a";
  step.result.state = StepState::failed;
  step.result.value = 17.25;
  testing::write_text(folder / "rig.commission.jsonl", commission::record_line(step));
  shown = body_of(ask("GET", "/api/v1/commission"));
  CHECK_FALSE(shown["good"].get<bool>());
  CHECK_EQUAL("a@b", shown["operator"].get<std::string>());
  bool found = false;
  for (const auto& each : shown["steps"]) {
    if (each["id"] != "lamp_a") continue;
    found = true;
    DOUBLES_EQUAL(17.25, each["value"].get<double>(), 0.0);
    CHECK_TRUE(each["changed"].get<bool>());
  }
  CHECK_TRUE(found);
  CHECK_TRUE(web_test::documented_fields("STEP:") == web_test::fields_of(shown["steps"][0]));
}
