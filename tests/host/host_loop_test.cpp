// The host's loop on a bus and a clock of this test's, and a series fired on it.
#include "host/loop/host_loop.hpp"

#include <map>
#include <string>

#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/sealed_command_t.hpp>

#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/encode.hpp"
#include "host/loop/series_runner.hpp"
#include "host/session/logged_transport.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::HostLoop;
using host::SeriesRunner;
using host::ShotResult;
using messages::Channel;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr std::int64_t kHost = 0x1234;
constexpr std::int64_t kBoot = 77;

std::string channel(Channel kind) { return messages::channel_name("bench", kind); }

struct Bus final : host::Transport {
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> arriving;
  std::map<std::string, int> published;
  std::vector<std::vector<std::uint8_t>> commands;
  bool failed = false;

  bool receive(std::chrono::milliseconds, std::span<const int>, const Receiver& receiver) override {
    for (const auto& [name, bytes] : std::exchange(arriving, {})) receiver(name, bytes);
    return !failed;
  }
  void publish(const std::string& name, Bytes bytes) override {
    ++published[name];
    if (name == channel(Channel::command)) commands.emplace_back(bytes.begin(), bytes.end());
  }
};

struct ManualClock final : host::Clock {
  Duration now = std::chrono::seconds{100};
  host::HostReading read() override { return {HostTime{now}, WallTime{now}, now}; }
};

struct Results final : host::HostListener {
  std::vector<ShotResult> results;
  std::vector<std::string> notifications;
  void on_shot_result(const ShotResult& result) override { results.push_back(result); }
  void on_notification(const std::string& text) override { notifications.push_back(text); }
};

status_t idle_status(std::int64_t last_sequence = 0) {
  status_t status{};
  status.schema_version = status_t::SCHEMA_VERSION;
  status.boot_id = kBoot;
  status.key_active = true;
  status.journal_ok = true;
  status.last_sequence = last_sequence;
  status.wall_ns = 1'800'000'000'000'000'000;
  return status;
}

}  // namespace

TEST_GROUP(HostLoop) {
  const authentication::Key key = authentication::Key::random();
  Bus bus;
  ManualClock clock;
  Results results;
  host_test::SyntheticShot made = host_test::make_shot({});

  host::HostLoopSettings settings(bool fires, bool with_key = true) const {
    host::HostLoopSettings settings{"bench", {}, kHost, fires};
    if (with_key) settings.key = key;
    return settings;
  }
  template <typename Message>
  void arrive(Channel kind, const Message& message) {
    bus.arriving.emplace_back(channel(kind), messages::encode(message));
  }
  void pass(HostLoop & loop, double seconds) {
    clock.now += from_seconds(seconds);
    CHECK_TRUE(loop.run_once());
  }
  command_t last_command() const {
    const auto body = authentication::unseal(key, "bench", bus.commands.back());
    command_t command;
    CHECK_TRUE(body && command.decode(body->data(), 0, static_cast<int>(body->size())) >= 0);
    return command;
  }
};

TEST(HostLoop, PublishesTheReadoutsOfItsOwnShotsAlone) {
  for (const auto& [fires, host_id, dry, readouts] :
       {std::tuple{true, kHost, false, 1}, std::tuple{true, kHost, true, 0},
        std::tuple{true, kHost + 1, false, 0}, std::tuple{false, kHost, false, 0}}) {
    bus.published.clear();
    results.results.clear();
    HostLoop loop(settings(fires), bus, clock);
    loop.add_listener(results);
    made.shot.host_id = host_id;
    made.shot.plan.dry = dry;
    made.shot.first_sequence = made.shot.last_sequence = 0;
    arrive(Channel::shot, made.shot);
    if (!dry) arrive(Channel::frame, made.frame);
    pass(loop, 0.02);
    LONGS_EQUAL(1, results.results.size());
    LONGS_EQUAL(readouts, bus.published[channel(Channel::readout)]);
  }
}

TEST(HostLoop, RequestsLostEventsIfItHasAKey) {
  for (const bool with_key : {false, true}) {
    bus.commands.clear();
    HostLoop loop(settings(false, with_key), bus, clock);
    arrive(Channel::status, idle_status(5));
    pass(loop, 0.02);
    pass(loop, 1.0);
    LONGS_EQUAL(with_key ? 1 : 0, bus.commands.size());
  }
  LONGS_EQUAL(command_t::RESEND, last_command().kind);
  LONGS_EQUAL(1, last_command().resend_first);
  LONGS_EQUAL(5, last_command().resend_last);
}

TEST(HostLoop, AFirmwareIsSilentAfterFiveHeartbeatsThatDidNotCome) {
  HostLoop loop(settings(false), bus, clock);
  CHECK_FALSE(loop.live_status().has_value());
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  const HostTime heard{clock.now};
  CHECK_EQUAL(heard, loop.last_message());
  pass(loop, 2.5);
  CHECK_TRUE(loop.live_status().has_value());
  pass(loop, 0.001);
  CHECK_FALSE(loop.live_status().has_value());
  CHECK_EQUAL(heard, loop.last_message());
}

TEST(HostLoop, SaysWithACommandWhenItWasSentByTheFirmwaresClock) {
  HostLoop loop(settings(true), bus, clock);
  status_t status = idle_status();
  status.boot_time_ns = 7'000'000'000;
  arrive(Channel::status, status);
  pass(loop, 0.0);
  pass(loop, 0.3);
  clock.now += from_seconds(0.1);  // what the host does before it sends
  loop.send(loop.commands().arm(kBoot));
  CHECK_EQUAL(7'400'000'000, last_command().sent_boot_time_ns);
  loop.send(loop.commands().arm(kBoot + 1));  // not heard
  CHECK_EQUAL(0, last_command().sent_boot_time_ns);
}

TEST(HostLoop, EndsWhenNothingCanBeReceived) {
  HostLoop loop(settings(false), bus, clock);
  bus.failed = true;
  CHECK_FALSE(loop.run_once());
}

TEST(HostLoop, ASeriesIsArmedFiredAndItsLostEventsFetched) {
  HostLoop loop(settings(true), bus, clock);
  SeriesRunner runner(loop, {});
  runner.step();
  CHECK_TRUE(runner.series().blocking_reason().empty());  // the first status had no time to come yet
  status_t status = idle_status(4);
  for (std::int64_t sequence = 1; sequence <= 3; ++sequence) {
    event_t event{};
    event.schema_version = event_t::SCHEMA_VERSION;
    event.boot_id = kBoot;
    event.sequence = sequence;
    arrive(Channel::event, event);
  }
  arrive(Channel::status, status);
  pass(loop, 0.02);
  runner.step();
  LONGS_EQUAL(command_t::ARM, last_command().kind);
  status.state = status_t::ARMED;
  status.arm_host_id = kHost;
  status.arm_token = 9;
  arrive(Channel::status, status);
  pass(loop, 0.02);
  runner.step();
  LONGS_EQUAL(command_t::FIRE, last_command().kind);
  LONGS_EQUAL(9, last_command().arm_token);
  ShotResult result;
  result.boot_id = kBoot;
  result.host_id = kHost;
  result.shot_id = 1;
  runner.on_shot_result(result);
  CHECK_FALSE(runner.fired());
  pass(loop, 0.02);
  runner.step();
  CHECK_TRUE(runner.fired());
  CHECK_FALSE(runner.finished());  // event 4 is missing
  pass(loop, 1.0);
  runner.step();
  CHECK_EQUAL(from_seconds(1.0), runner.recovering_for());
  LONGS_EQUAL(command_t::RESEND, last_command().kind);
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = kBoot;
  event.sequence = 4;
  arrive(Channel::event, event);
  arrive(Channel::status, status);
  pass(loop, 0.1);
  runner.step();
  CHECK_TRUE(runner.finished());
  CHECK_FALSE(runner.stop());
}

TEST(HostLoop, AStoppedSeriesIsDisarmedWithinASecondOrLeft) {
  HostLoop loop(settings(true), bus, clock);
  SeriesRunner runner(loop, {});
  status_t status = idle_status();
  status.state = status_t::ARMED;
  status.arm_host_id = kHost;
  status.arm_token = 9;
  arrive(Channel::status, status);
  pass(loop, 0.02);
  CHECK_TRUE(runner.stop());
  CHECK_FALSE(runner.stop());
  LONGS_EQUAL(command_t::DISARM, last_command().kind);
  pass(loop, 0.9);
  runner.step();
  CHECK_FALSE(runner.fired());  // still disarming
  pass(loop, 0.2);
  runner.step();
  CHECK_TRUE(runner.fired());
}

TEST(HostLoop, TheLogHoldsWhatCameAndWhatWasPublishedOnce) {
  testing::TemporaryFolder folder;
  auto session = host::SessionFolder::open(folder.path(), "20260131T093000Z", "", "");
  host::LoggedTransport transport(bus, **session, clock, "bench", kHost);
  strobe_msgs::readout_t readout{};
  readout.schema_version = strobe_msgs::readout_t::SCHEMA_VERSION;
  readout.host_id = kHost;
  strobe_msgs::frame_t frame = made.frame;
  frame.host_id = kHost;
  transport.publish(channel(Channel::readout), messages::encode(readout));
  arrive(Channel::readout, readout);  // both come back by multicast
  arrive(Channel::frame, frame);
  frame.host_id = readout.host_id = kHost + 1;
  arrive(Channel::readout, readout);
  arrive(Channel::frame, frame);
  arrive(Channel::status, idle_status());
  std::vector<std::string> received;
  CHECK_TRUE(transport.receive(
      {}, {}, [&](const std::string& name, std::span<const std::uint8_t>) { received.push_back(name); }));
  LONGS_EQUAL(3, received.size());
  lcm::LogFile log((folder / "host-20260131T093000Z.lcmlog").string(), "r");
  std::vector<std::string> logged;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    logged.push_back(event->channel);
    CHECK_EQUAL(clock.now, Duration{microseconds{event->timestamp}});
  }
  LONGS_EQUAL(4, logged.size());
  CHECK_EQUAL(channel(Channel::readout), logged[0]);
  for (std::size_t i = 0; i < received.size(); ++i) CHECK_EQUAL(received[i], logged[i + 1]);
}
