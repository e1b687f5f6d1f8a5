#include "host/web/live_state.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/host/web/documented.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::web;
using nlohmann::json;
using strobe_msgs::status_t;

namespace {

host::Shot shot(int id, double vx_mps, const std::string& utc) {
  host::Shot result;
  result.shot_id = id;
  result.boot_id = 0x2a;
  result.utc = utc;
  result.readout.value[reduction::Quantity::vx_td_mps] = vx_mps;
  result.readout.sd[reduction::Quantity::vx_td_mps] = 0.3;
  result.readout.sd_systematic[reduction::Quantity::vx_td_mps] = 0.4;
  return result;
}

LiveStatus heard(std::int8_t state) {
  LiveStatus live;
  status_t status{};
  status.state = state;
  status.key_active = true;
  status.estop_active = false;
  live.status = std::make_shared<const status_t>(status);
  live.silent = false;
  live.age_s = 0.25;
  return live;
}

json status_of(const LiveStatus& live) { return json::parse(status_json(live).dump()); }

}  // namespace

TEST_GROUP(LiveState) {
  EventHub hub;
  LiveChannel channel;
  LiveState state{{"fire", "1.2.3", "bench", "run1"}, channel, hub};

  void tell(LiveMessage message) {
    std::deque<LiveMessage> messages;
    messages.push_back(std::move(message));
    while (!messages.empty()) channel.put(messages);
  }
  /// Waits for an event that ends so.
  void await(const std::string& event, const std::string& end) {
    while (true) {
      const std::string text = hub.take_after(0, 1 << 24).text;
      const std::size_t at = text.rfind("event: " + event + "\n");
      if (at != text.npos && text.find(end, at) != text.npos) return;
      std::this_thread::yield();
    }
  }
  json live() { return json::parse(state.live_json()); }
};

TEST(LiveState, BeforeAnythingWasHeardSaysSo) {
  const json is = live();
  CHECK_EQUAL("fire", is["program"].get<std::string>());
  CHECK_EQUAL("run1", is["session"].get<std::string>());
  CHECK_EQUAL("never_heard", is["status"]["state"].get<std::string>());
  CHECK_EQUAL("unknown", is["status"]["estop"].get<std::string>());
  CHECK_EQUAL("no firmware heard", is["status"]["missing"].get<std::string>());
  CHECK(is["series"].is_null() && is["last"].is_null() && is["notifications"].empty());
  CHECK(is["can"] == json({{"stop", false}, {"disarm", false}, {"edit", true}}));
  LONGS_EQUAL(0, is["event_id"].get<int>());
  CHECK(!state.timing_json());
}

TEST(LiveState, TellsAShotThenTheSeries) {
  tell(shot(3, 15.0, "2026-01-31T09:30:00.000Z"));
  await("series", "{}");
  tell(shot(4, 16.0, "2026-01-31T09:30:09.000Z"));
  await("shot", "\"name\":\"4\"");
  await("series", "{}");
  while (live()["series"]["points"].size() < 2) std::this_thread::yield();
  const json is = live();
  CHECK_EQUAL("4", is["last"]["name"].get<std::string>());
  CHECK_EQUAL("run1", is["last"]["session"].get<std::string>());
  CHECK_EQUAL("2026-01-31T09:30:09.000Z", is["last"]["utc"].get<std::string>());
  DOUBLES_EQUAL(0.5, is["last"]["values"]["vx_td_mps"]["sd"].get<double>(), 1e-12);  // of 0.3 and 0.4
  DOUBLES_EQUAL(15.5, is["series"]["summary"]["quantities"]["vx_td_mps"]["mean"].get<double>(), 1e-12);
}

TEST(LiveState, TellsTheSeriesOfTheNewestShotsConditionAlone) {
  const auto on = [](const char* surface, int id, double vx_mps) {
    host::Shot one = shot(id, vx_mps, "2026-01-31T09:30:00.000Z");
    one.readout.record = {{"spin", "zero"}, {"angle_deg", "23"}, {"surface_name", surface}};
    return one;
  };
  const std::array shots{on("acrylic", 1, 15.0), on("cushion", 2, 12.0), on("acrylic", 3, 16.0)};
  const std::array<double, 3> means{15.0, 12.0, 15.5};
  const std::array names{"zero 23°, acrylic", "zero 23°, cushion", "zero 23°, acrylic"};
  for (std::size_t i = 0; i < shots.size(); ++i) {
    tell(shots[i]);
    while (live()["last"]["shot_id"] != shots[i].shot_id || live()["series"].is_null() ||
           live()["series"]["points"].back()["name"] != std::to_string(shots[i].shot_id))
      std::this_thread::yield();
    const json series = live()["series"];
    DOUBLES_EQUAL(means[i], series["summary"]["quantities"]["vx_td_mps"]["mean"].get<double>(), 1e-12);
    CHECK_EQUAL(names[i], series["conditions"][0]["name"].get<std::string>());
  }
  LONGS_EQUAL(2, live()["series"]["points"].size());
}

TEST(LiveState, KeepsTheNewestNotificationsAsText) {
  for (std::size_t i = 0; i < LiveState::kMaxNotifications + 3; ++i)
    tell(LiveNotification{"2026-01-31T09:30:00.000Z", "<b>\"" + std::to_string(i)});
  await("notification", "<b>\\\"52");
  const json is = live();
  LONGS_EQUAL(LiveState::kMaxNotifications, is["notifications"].size());
  CHECK_EQUAL("<b>\"3", is["notifications"][0]["text"].get<std::string>());
}

TEST(LiveState, HasTheFieldsThatTheInterfacesDescriptionLists) {
  CHECK(web_test::documented_fields("STATUS:") == web_test::fields_of(status_json({})));
}

TEST(LiveState, NamesWhatTheFirmwareIsDoing) {
  const std::vector<std::pair<std::int8_t, std::string>> names{
      {status_t::IDLE, "idle"},   {status_t::ARMED, "armed"}, {status_t::FIRING, "firing"},
      {status_t::FAULT, "fault"}, {status_t::SPENT, "spent"}, {99, "fault"}};
  for (const auto& [number, name] : names)
    CHECK_EQUAL(name, status_of(heard(number))["state"].get<std::string>());
}

TEST(LiveState, OfASilentFirmwareKnowsNeitherKeyNorEStop) {
  LiveStatus live = heard(status_t::IDLE);
  CHECK_EQUAL("on", status_of(live)["key"].get<std::string>());
  CHECK_EQUAL("released", status_of(live)["estop"].get<std::string>());
  live.silent = true;
  const json silent = status_of(live);
  CHECK_EQUAL("silent", silent["state"].get<std::string>());
  CHECK_EQUAL("unknown", silent["key"].get<std::string>());
  CHECK_EQUAL("unknown", silent["estop"].get<std::string>());
}

TEST(LiveState, AsksTheHostForWhatItCanDoAlone) {
  Router router;
  add_live_routes(router, state);
  const auto asked = [&router](const std::string& path, const std::string& body) {
    Request request{"POST", path, {}, {}, body, "10.0.0.7"};
    return router.route(request).status;
  };
  LONGS_EQUAL(409, asked("/api/v1/stop", "{}"));
  LONGS_EQUAL(409, asked("/api/v1/disarm", "{}"));
  LiveStatus status = heard(status_t::ARMED);
  status.can_disarm = true;
  tell(status);
  await("status", "\"can\":{\"stop\":false,\"disarm\":true}");
  LONGS_EQUAL(409, asked("/api/v1/stop", "{}"));
  for (const char* body : {"", "null", "[]", "{\"a\":1}", "{", "disarm"})
    LONGS_EQUAL(400, asked("/api/v1/disarm", body));
  LONGS_EQUAL(400, asked("/api/v1/disarm", std::string(200'000, '[')));
  CHECK(channel.take_commands().empty());
  std::vector<LiveCommand> commands;
  std::thread loop([&] {
    while (commands.empty()) commands = channel.take_commands();
  });
  LONGS_EQUAL(202, asked("/api/v1/disarm", " {} "));
  loop.join();
  LONGS_EQUAL(1, commands.size());
  CHECK(commands[0].kind == LiveCommand::Kind::disarm);
  CHECK_EQUAL("10.0.0.7", commands[0].from);
}

TEST(LiveState, OfALoopThatStandsStillSaysSoWithinASecond) {
  Router router;
  add_live_routes(router, state);
  LiveStatus status = heard(status_t::ARMED);
  status.can_disarm = true;
  tell(status);
  await("status", "\"can\":{\"stop\":false,\"disarm\":true}");
  Request request{"POST", "/api/v1/disarm", {}, {}, "{}", "10.0.0.7"};
  const Response answer = router.route(request);
  LONGS_EQUAL(503, answer.status);
  STRCMP_CONTAINS("did not react within 1 s", answer.body->c_str());
  for (std::size_t i = 0; i < LiveChannel::kMaxCommands; ++i) LONGS_EQUAL(503, router.route(request).status);
  LONGS_EQUAL(LiveChannel::kMaxCommands, channel.take_commands().size());
}

TEST(LiveState, HasNothingThatFires) {
  Router router;
  add_live_routes(router, state);
  for (const char* path :
       {"/api/v1/fire", "/api/v1/arm", "/api/v1/shots", "/api/v1/command", "/api/v1/clear"}) {
    Request request{"POST", path, {}, {}, "{}", ""};
    LONGS_EQUAL(404, router.route(request).status);
  }
}
