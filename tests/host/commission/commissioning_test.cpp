// The state machine of commissioning, on a bus and a clock of this test's.
#include "host/commission/commissioning.hpp"

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "tests/host/commission/trains.hpp"
#include "tests/support/host_bench.hpp"
#include "tests/support/sealed_sender.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using messages::Channel;
using strobe_msgs::command_t;
using strobe_msgs::status_t;

constexpr std::int64_t kHost = 0x1234, kBoot = 7;

std::string channel(Channel kind) { return messages::channel_name("bench", kind); }

/// Passes at once, or after a shot; says what became of it.
class ScriptedStep final : public Step {
 public:
  ScriptedStep(std::string id, Needs needs, StepState outcome)
      : Step({{id, id, {"lamps"}}}, needs), outcome_(outcome) {}
  std::string briefing(const host::RigFile&) const override { return "does " + infos()[0].id; }
  void begin(const Situation&) override {
    ++begun;
    fired_ = false;
  }
  Request step(const Situation&) override {
    if (needs().outputs && !fired_) {
      Fire fire;
      fire.plan.dry = !needs().machine;
      fire.plan.exposure = milliseconds{300};
      fire.words = "flashes";
      return fire;
    }
    if (!why_not.empty()) return Done{{failed("no_shot", why_not, "mend it")}};
    StepResult result;
    result.state = outcome_;
    return Done{{result}};
  }
  void on_shot(host::Shot shot) override {
    fired_ = true;
    shots.push_back(std::move(shot));
  }
  void on_no_shot(const std::string& why) override {
    fired_ = true;
    why_not = why;
  }

  int begun = 0;
  std::vector<host::Shot> shots;
  std::string why_not;

 private:
  StepState outcome_;
  bool fired_ = false;
};

struct Told final : CommissioningListener {
  std::vector<std::string> prompts, results;
  void on_prompt(const StepView& step, const Prompt& prompt) override {
    prompts.push_back(step.info.id + (prompt.moves ? " moves" : ""));
  }
  void on_result(const StepView& step) override {
    results.push_back(step.info.id + " " + std::string(name(step.result->state)));
  }
};

}  // namespace

TEST_GROUP(Commissioning) {
  const authentication::Key key = authentication::Key::random();
  testing::SealedSender lab{key};
  testing::RememberingBus bus;
  testing::ManualClock clock;
  Told told;
  status_t status{};
  std::vector<ScriptedStep*> scripted;
  std::vector<std::unique_ptr<Step>> steps;
  std::unique_ptr<host::HostLoop> loop;
  std::unique_ptr<Commissioning> commissioning;
  CommissioningSettings settings;

  void setup() override {
    settings.rig = *host::read_rig("rig = \"bench\"\n[lamps]\ndelay_us = 12.0\n", "rig.toml");
    settings.attended = false;
    settings.patience = std::chrono::seconds{2};
    status.schema_version = status_t::SCHEMA_VERSION;
    status.boot_id = kBoot;
    status.key_active = true;
    status.journal_ok = true;
    status.wall_ns = 1'800'000'000'000'000'000;
  }

  void add(const std::string& id, Needs needs = {}, StepState outcome = StepState::passed) {
    auto step = std::make_unique<ScriptedStep>(id, needs, outcome);
    scripted.push_back(step.get());
    steps.push_back(std::move(step));
  }
  void begin(const Record& former = {}) {
    loop =
        std::make_unique<host::HostLoop>(host::HostLoopSettings{"bench", {}, kHost, true, key}, bus, clock);
    commissioning = std::make_unique<Commissioning>(*loop, settings, std::move(steps), former);
    commissioning->add_listener(told);
  }
  template <typename Message>
  void arrive(Channel kind, const Message& message) {
    bus.arriving.emplace_back(channel(kind), lab.packet(channel(kind), message));
  }
  void tell_status() {
    status.mono_ns = status.boot_time_ns = clock.now.count();
    arrive(Channel::status, status);
  }
  void turn(int times = 1) {
    for (int i = 0; i < times; ++i) {
      clock.now += milliseconds{20};
      loop->run_once();
      commissioning->step();
    }
  }
  command_t last_command() {
    command_t command{};
    if (bus.sent_on(channel(Channel::command)).empty()) return command;
    const auto body = authentication::unseal(key, "bench", bus.sent_on(channel(Channel::command)).back());
    CHECK_TRUE(body && command.decode(body->data(), 0, static_cast<int>(body->size())) >= 0);
    return command;
  }
  /// Arms and fires as a firmware does, up to the shot's start.
  void give_token() {
    tell_status();
    turn(60);  // another rig of the name would be heard by now
    LONGS_EQUAL(+command_t::ARM, last_command().kind);
    status.state = status_t::ARMED;
    status.arm_host_id = kHost;
    status.arm_token = 99;
    tell_status();
    turn(2);
    LONGS_EQUAL(+command_t::FIRE, last_command().kind);
    status.state = status_t::FIRING;
    status.arm_host_id = status.arm_token = 0;
    tell_status();
    turn(2);
  }
  void end_shot() {
    auto shot = commission_test::train(Lamps::a, {});
    shot.schema_version = strobe_msgs::shot_t::SCHEMA_VERSION;
    shot.host_id = kHost;
    shot.boot_id = kBoot;
    shot.shot_id = ++status.last_shot_id;
    shot.plan = last_command().plan;
    status.state = status_t::IDLE;
    arrive(Channel::shot, shot);
    tell_status();
    turn(3);
  }
  std::string joined(const std::vector<std::string>& words) const {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return text;
  }
  Record passed_before(const std::string& id, const std::string& utc = "1970-01-01T00:00:00.000Z") {
    Record record;
    RecordedStep step{utc, "a@b", "1", "bench", tables_hash(settings.rig, {"lamps"}), id, {}};
    step.result.id = id;
    step.result.state = StepState::passed;
    record.steps.push_back(step);
    return record;
  }
};

TEST(Commissioning, TakesTheStepsInTheirOrder) {
  add("one");
  add("two", {}, StepState::failed);
  add("three");
  begin();
  turn(10);
  CHECK_TRUE(commissioning->finished());
  CHECK_EQUAL("one passed, two failed, three passed", joined(told.results));
}

TEST(Commissioning, AsksAPersonBeforeEachStepAndSaysWhatMoves) {
  settings.attended = true;
  add("one");
  add("two", {.outputs = true});
  begin();
  turn(5);
  CHECK_EQUAL("one", joined(told.prompts));
  commissioning->answer(Answer::yes);
  turn(3);
  CHECK_EQUAL("one, two moves", joined(told.prompts));
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::command)).size());
  commissioning->answer(Answer::skip);
  turn(3);
  CHECK_EQUAL("one passed, two skipped", joined(told.results));
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::command)).size());
}

TEST(Commissioning, NothingMovesForAnEmptyLine) {
  const Prompt watches{Prompt::Kind::begin, "", false}, moves{Prompt::Kind::begin, "", true},
      question{Prompt::Kind::question, "", false};
  CHECK_TRUE(answer_of(watches, "") == Answer::yes);
  CHECK_FALSE(answer_of(moves, "").has_value());
  CHECK_FALSE(answer_of(moves, "yn").has_value());
  CHECK_TRUE(answer_of(moves, "y") == Answer::yes);
  CHECK_TRUE(answer_of(moves, "s") == Answer::skip);
  CHECK_FALSE(answer_of(question, "").has_value());
  CHECK_FALSE(answer_of(question, "s").has_value());
  CHECK_TRUE(answer_of(question, "n") == Answer::no);
}

TEST(Commissioning, RepeatsAStepThatFailedOrDidNotTellIfAPersonWants) {
  settings.attended = true;
  add("one", {}, StepState::failed);
  add("two", {}, StepState::not_told);
  begin();
  for (const ScriptedStep* step : scripted) {
    turn(2);
    commissioning->answer(Answer::yes);
    turn(2);
    CHECK_TRUE(commissioning->prompt()->kind == Prompt::Kind::after_failure);
    commissioning->answer(Answer::yes);
    turn(2);
    commissioning->answer(Answer::yes);
    turn(2);
    LONGS_EQUAL(2, step->begun);
    commissioning->answer(Answer::no);
  }
  turn(2);
  CHECK_TRUE(commissioning->finished());
}

TEST(Commissioning, RepeatsWhatWasNotToldBefore) {
  Record former = passed_before("one");
  former.steps[0].result.state = StepState::not_told;
  add("one");
  begin(former);
  turn(5);
  CHECK_EQUAL("one passed", joined(told.results));
}

TEST(Commissioning, GoesOnWhereTheRecordEnds) {
  add("one");
  add("two");
  begin(passed_before("one"));
  turn(5);
  CHECK_EQUAL("two passed", joined(told.results));
  CHECK_TRUE(commissioning->views()[0].state == StepState::passed);
}

TEST(Commissioning, RepeatsWhatWasProvenBeforeTheRigFileChanged) {
  add("one");
  const Record former = passed_before("one");
  settings.rig = *host::read_rig("rig = \"bench\"\n[lamps]\ndelay_us = 13.0\n", "rig.toml");
  begin(former);
  turn(5);
  CHECK_EQUAL("one passed", joined(told.results));
}

TEST(Commissioning, DoesOnlyWhatIsNamedAndLeavesOutWithItsReason) {
  settings.only = {"two"};
  for (const char* const id : {"one", "two", "three"}) add(id);
  begin();
  turn(5);
  CHECK_EQUAL("two passed", joined(told.results));
}

TEST(Commissioning, LeavesAStepOutWithItsReason) {
  settings.skip = {{"one", "no such lamp"}};
  add("one");
  add("two");
  begin();
  turn(5);
  CHECK_EQUAL("one skipped, two passed", joined(told.results));
  CHECK_EQUAL("left out: no such lamp", commissioning->views()[0].result->words);
}

TEST(Commissioning, BeginsWhereItIsTold) {
  settings.from = "two";
  for (const char* const id : {"one", "two", "three"}) add(id);
  begin(passed_before("two"));
  turn(5);
  CHECK_EQUAL("two passed, three passed", joined(told.results));
}

TEST(Commissioning, ThrowsNothingBeforeKeyAndEStopHavePassed) {
  add("trigger", {.outputs = true, .machine = true});
  begin();
  tell_status();
  turn(20);
  CHECK_EQUAL("trigger failed", joined(told.results));
  LONGS_EQUAL(0, scripted[0]->begun);
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::command)).size());
}

TEST(Commissioning, FiresWhatAStepAsksForOnce) {
  add("lamp", {.outputs = true});
  begin();
  turn(2);
  give_token();
  CHECK_TRUE(last_command().plan.dry != 0);
  end_shot();
  LONGS_EQUAL(1, scripted[0]->shots.size());
  LONGS_EQUAL(100, scripted[0]->shots[0].summary->flash_count);
  CHECK_EQUAL("lamp passed", joined(told.results));
  CHECK_TRUE(commissioning->finished());
}

TEST(Commissioning, SaysWhyNothingCanBeFired) {
  status.key_active = false;
  add("lamp", {.outputs = true});
  begin();
  for (int i = 0; i < 20; ++i) {
    tell_status();
    turn(10);
  }
  CHECK_EQUAL("lamp failed", joined(told.results));
  CHECK_TRUE(scripted[0]->why_not.find("the key is off") != std::string::npos);
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::command)).size());
}

TEST(Commissioning, BeginsNoStepAfterAStopWhereNobodySaysYesAnew) {
  status.key_active = false;
  add("lamp", {.outputs = true});
  add("next", {.outputs = true});
  begin();
  for (int i = 0; i < 20; ++i) {
    tell_status();
    turn(10);
    status.key_active = true;  // and so the rig is well again
  }
  CHECK_EQUAL("lamp failed", joined(told.results));
  CHECK_TRUE(commissioning->stopped());
  LONGS_EQUAL(0, scripted[1]->begun);
}

TEST(Commissioning, AYesResetsTheStopsFromBeforeIt) {
  settings.attended = true;
  add("lamp", {.outputs = true});
  begin();
  status.state = status_t::STOPPED;
  tell_status();
  turn(500);  // ten seconds before the operator says yes
  const std::int64_t yes_ns = clock.now.count();
  commissioning->answer(Answer::yes);
  tell_status();
  turn(2);
  LONGS_EQUAL(+command_t::RESET, last_command().kind);
  CHECK(last_command().sent_boot_time_ns <= yes_ns);
  CHECK(last_command().sent_boot_time_ns > yes_ns - 1'000'000'000);
}

TEST(Commissioning, DisarmsWhereItIsStopped) {
  add("lamp", {.outputs = true});
  begin();
  turn(2);
  give_token();
  commissioning->stop("the operator");
  LONGS_EQUAL(+command_t::DISARM, last_command().kind);
  CHECK_FALSE(commissioning->finished());
  strobe_msgs::event_t disarmed{};
  disarmed.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  disarmed.boot_id = kBoot;
  disarmed.sequence = 1;
  disarmed.kind = strobe_msgs::event_t::DISARMED;
  disarmed.detail = fmt::format("disarmed by command {} of {:x}", last_command().command_id, kHost);
  arrive(Channel::event, disarmed);
  turn(2);
  CHECK_TRUE(commissioning->finished());
  CHECK_TRUE(commissioning->stopped());
  LONGS_EQUAL(0, told.results.size());
}
