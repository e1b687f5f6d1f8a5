// The host's loop on a bus and a clock of this test's, and a series fired on it.
#include "host/loop/host_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <string>

#include <strobe_msgs/readout_t.hpp>
#include <strobe_msgs/sealed_command_t.hpp>

#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "common/messages/well_formed.hpp"
#include "host/loop/series_runner.hpp"
#include "host/session/session_folder.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/host_bench.hpp"
#include "tests/support/sealed_sender.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"


namespace {

using namespace strobe;
using host::HostLoop;
using host::SeriesRunner;
using host::Shot;
using messages::Channel;
using strobe_msgs::command_t;
using strobe_msgs::event_t;
using strobe_msgs::status_t;

constexpr std::int64_t kHost = 0x1234;
constexpr std::int64_t kBoot = 77;

std::string channel(Channel kind) { return messages::channel_name("bench", kind); }

struct Results final : host::HostListener {
  std::vector<Shot> results;
  std::vector<std::string> notifications;
  void on_shot_result(const Shot& result) override { results.push_back(result); }
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
  testing::SealedSender lab{key};
  testing::RememberingBus bus;
  testing::ManualClock clock;
  Results results;
  host_test::SyntheticShot made = host_test::make_shot({});

  host::HostLoopSettings settings(bool fires, bool with_key = true) const {
    host::HostLoopSettings settings{"bench", {}, kHost, fires};
    if (with_key) settings.key = key;
    return settings;
  }
  template <typename Message>
  void arrive(Channel kind, const Message& message) {
    bus.arriving.emplace_back(channel(kind), lab.packet(channel(kind), message));
  }
  void pass(HostLoop & loop, double seconds) {
    clock.now += from_seconds(seconds);
    CHECK_TRUE(loop.run_once());
  }
  command_t last_command() const {
    const auto body = authentication::unseal(key, "bench", bus.sent_on(channel(Channel::command)).back());
    command_t command;
    CHECK_TRUE(body && command.decode(body->data(), 0, static_cast<int>(body->size())) >= 0);
    return command;
  }
};

TEST(HostLoop, PublishesTheReadoutsOfItsOwnShotsAlone) {
  for (const auto& [fires, host_id, dry, readouts] :
       {std::tuple{true, kHost, false, 1}, std::tuple{true, kHost, true, 0},
        std::tuple{true, kHost + 1, false, 0}, std::tuple{false, kHost, false, 0}}) {
    bus.sent.clear();
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
    LONGS_EQUAL(readouts, bus.sent_on(channel(Channel::readout)).size());
  }
}

TEST(HostLoop, RequestsLostEventsIfItHasAKey) {
  for (const bool with_key : {false, true}) {
    bus.sent.clear();
    HostLoop loop(settings(false, with_key), bus, clock);
    arrive(Channel::status, idle_status(5));
    pass(loop, 0.02);
    pass(loop, 1.0);
    LONGS_EQUAL(with_key ? 1 : 0, bus.sent_on(channel(Channel::command)).size());
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

namespace {

status_t heard_at(std::int64_t boot_time_ns) {
  status_t status = idle_status();
  status.boot_time_ns = boot_time_ns;
  return status;
}
/// What the firmware answers a DISARM with.
event_t disarmed(const command_t& command, std::int64_t sequence) {
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = kBoot;
  event.sequence = sequence;
  event.kind = event_t::DISARMED;
  event.detail = fmt::format("disarmed by command {} of {:x} anna@desk", command.command_id, command.host_id);
  return event;
}

}  // namespace

TEST(HostLoop, ADisarmIsRepeatedUntilItIsConfirmed) {
  HostLoop loop(settings(false), bus, clock);
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  loop.disarm("the page");
  for (std::size_t sent = 1; sent <= 4; ++sent) {
    LONGS_EQUAL(sent, bus.sent_on(channel(Channel::command)).size());
    LONGS_EQUAL(+command_t::DISARM, last_command().kind);
    pass(loop, 0.1);
  }
  status_t stopped = idle_status();
  stopped.state = status_t::STOPPED;  // by an earlier stop, which somebody may be about to reset
  arrive(Channel::status, stopped);
  pass(loop, 0.02);
  CHECK_TRUE(loop.disarming());
  arrive(Channel::event, disarmed(last_command(), 1));
  pass(loop, 0.02);
  CHECK_FALSE(loop.disarming());
  bus.sent.clear();
  pass(loop, 0.3);
  for (const auto& command : bus.sent_on(channel(Channel::command))) {
    const auto body = authentication::unseal(key, "bench", command);
    command_t sent;
    CHECK_TRUE(body && sent.decode(body->data(), 0, static_cast<int>(body->size())) >= 0);
    CHECK(sent.kind != command_t::DISARM);
  }
}

TEST(HostLoop, ADisarmIsConfirmedByTheAnswerToItAlone) {
  HostLoop loop(settings(false), bus, clock);
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  loop.disarm("the page");
  const command_t before = last_command();
  loop.disarm("the page, once more");
  command_t other = last_command();
  arrive(Channel::event, disarmed(before, 1));  // of the request before
  other.host_id = kHost + 1;
  arrive(Channel::event, disarmed(other, 2));  // of another host
  event_t elsewhere = disarmed(last_command(), 3);
  elsewhere.boot_id = kBoot - 1;
  arrive(Channel::event, elsewhere);
  event_t words = disarmed(last_command(), 4);
  words.detail = "disarmed by command";
  arrive(Channel::event, words);
  pass(loop, 0.02);
  CHECK_TRUE(loop.disarming());
}

TEST(HostLoop, ADisarmThatIsNotConfirmedIsADangerWithinASecond) {
  HostLoop loop(settings(false), bus, clock);
  loop.add_listener(results);
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  loop.disarm("the page");
  for (int i = 0; i < 9; ++i) pass(loop, 0.1);
  STRCMP_CONTAINS("DISARM NOT CONFIRMED", loop.session().danger().c_str());
  CHECK(std::ranges::any_of(results.notifications, [](const std::string& text) {
    return text.find("press the e-stop") != std::string::npos;
  }));
  arrive(Channel::event, disarmed(last_command(), 1));
  pass(loop, 0.02);
  CHECK_EQUAL("", loop.session().danger());
}

TEST(HostLoop, ASilentFirmwareIsDisarmedToo) {
  HostLoop loop(settings(false), bus, clock);
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  pass(loop, 60.0);
  CHECK_FALSE(loop.live_status().has_value());
  loop.disarm("the page");
  LONGS_EQUAL(+command_t::DISARM, last_command().kind);
  LONGS_EQUAL(kBoot, last_command().boot_id);
}

TEST(HostLoop, AFirmwareThatIsHeardOnlyAfterTheDisarmGetsItThen) {
  HostLoop loop(settings(false), bus, clock);
  loop.disarm("the page");
  pass(loop, 0.6);
  LONGS_EQUAL(0, bus.sent_on(channel(Channel::command)).size());
  STRCMP_CONTAINS("DISARM NOT CONFIRMED", loop.session().danger().c_str());
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  pass(loop, 0.1);
  LONGS_EQUAL(+command_t::DISARM, last_command().kind);
}

TEST(HostLoop, SaysWithAResetWhenThePersonActedByTheFirmwaresClock) {
  HostLoop loop(settings(true), bus, clock);
  pass(loop, 2.0);
  arrive(Channel::status, heard_at(7'000'000'000));
  pass(loop, 0.3);
  pass(loop, 5.0);
  loop.send(loop.commands().reset(kBoot));  // since the loop was made, 2.3 s before the status was heard
  CHECK_EQUAL(4'700'000'000, last_command().sent_boot_time_ns);
  loop.person_acted();
  loop.send(loop.commands().reset(kBoot));
  CHECK_EQUAL(12'000'000'000, last_command().sent_boot_time_ns);
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
  STRCMP_CONTAINS("listening for another rig", runner.series().blocking_reason().c_str());
  pass(loop, 1.2);
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
  Shot result;
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
  CHECK_FALSE(runner.stop("the operator"));
}

TEST(HostLoop, AStoppedSeriesWaitsForTheDisarmsConfirmationTenSecondsAtMost) {
  for (const bool confirmed : {true, false}) {
    HostLoop loop(settings(true), bus, clock);
    SeriesRunner runner(loop, {});
    status_t status = idle_status();
    status.state = status_t::ARMED;
    status.arm_host_id = kHost + 1;  // whoever armed it
    status.arm_token = 9;
    arrive(Channel::status, status);
    pass(loop, 0.02);
    CHECK_TRUE(runner.stop("the operator"));
    CHECK_FALSE(runner.stop("the operator"));
    LONGS_EQUAL(+command_t::DISARM, last_command().kind);
    pass(loop, 9.9);
    runner.step();
    CHECK_FALSE(runner.fired());  // still disarming
    if (confirmed) arrive(Channel::event, disarmed(last_command(), 1));
    pass(loop, confirmed ? 0.02 : 0.2);
    runner.step();
    CHECK_TRUE(runner.fired());
    CHECK_EQUAL(!confirmed, loop.disarming());
  }
}

TEST(HostLoop, ASeriesEndsWhenThisComputerWasSuspended) {
  HostLoop loop(settings(true), bus, clock);
  SeriesRunner runner(loop, {});
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  clock.asleep += from_seconds(3600.0);  // overnight
  arrive(Channel::status, idle_status());
  pass(loop, 0.02);
  runner.step();
  CHECK_TRUE(runner.series().finished());
  STRCMP_CONTAINS("this computer was suspended", runner.series().blocking_reason().c_str());
}

TEST(HostLoop, TheLogHoldsWhatIsActedOnAndWhatWasPublishedOnceWithItsSeals) {
  testing::TemporaryFolder folder;
  auto session = host::SessionFolder::open(folder.path(), "20260131T093000Z", "", "");
  host::LoggedTransport transport(bus, **session, clock);
  HostLoop loop(settings(true), transport, clock);
  made.shot.host_id = kHost;
  made.shot.first_sequence = made.shot.last_sequence = 0;
  arrive(Channel::status, idle_status());
  bus.arriving.emplace_back(channel(Channel::shot), messages::encode(made.shot));  // a stranger's
  bus.arriving.push_back(bus.arriving.front());                                    // came before
  arrive(Channel::shot, made.shot);
  arrive(Channel::frame, made.frame);
  pass(loop, 0.02);
  bus.arriving = bus.sent;  // comes back by multicast
  strobe_msgs::readout_t readout{};
  readout.schema_version = strobe_msgs::readout_t::SCHEMA_VERSION;
  readout.host_id = kHost + 1;
  arrive(Channel::readout, readout);
  pass(loop, 0.02);
  lcm::LogFile log((folder / "host-20260131T093000Z.lcmlog").string(), "r");
  const authentication::PacketSeal seal(key);
  std::vector<std::string> logged;
  while (const lcm::LogEvent* event = log.readNextEvent()) {
    logged.push_back(event->channel);
    CHECK_TRUE(seal.open(event->channel, {static_cast<const std::uint8_t*>(event->data),
                                          static_cast<std::size_t>(event->datalen)})
                   .has_value());
  }
  const std::vector<std::string> expected{channel(Channel::status), channel(Channel::shot),
                                          channel(Channel::frame), channel(Channel::readout),
                                          channel(Channel::readout)};
  CHECK_EQUAL(expected, logged);
}

TEST(HostLoop, ActsOnNothingThatIsNotTheLabs) {
  HostLoop loop(settings(true), bus, clock);
  loop.add_listener(results);
  SeriesRunner runner(loop, {});
  strobe::testing::SealedSender stranger{authentication::Key::random()};
  event_t event{};
  event.schema_version = event_t::SCHEMA_VERSION;
  event.boot_id = kBoot;
  event.sequence = 7;  // six before it would be missing
  made.shot.host_id = kHost;
  made.shot.aborted = true;
  made.shot.first_sequence = made.shot.last_sequence = 0;
  const auto forge = [&](Channel kind, const auto& message) {
    const std::string name = channel(kind);
    const std::vector<std::uint8_t> bare = messages::encode(message);
    bus.arriving.emplace_back(name, bare);
    bus.arriving.emplace_back(name, stranger.packet(name, message));
    std::vector<std::uint8_t> altered = lab.packet(name, message);
    altered[bare.size() / 2] ^= 1;
    bus.arriving.emplace_back(name, altered);
    // Another channel's packet, and another rig's.
    bus.arriving.emplace_back(name, lab.packet(channel(Channel::readout), message));
    bus.arriving.emplace_back(name, lab.packet("STROBE/pitch/SHOT", message));
  };
  status_t armed = idle_status(9);
  armed.state = status_t::ARMED;
  armed.arm_host_id = kHost;
  armed.arm_token = 9;
  forge(Channel::status, armed);
  forge(Channel::event, event);
  forge(Channel::shot, made.shot);
  forge(Channel::frame, made.frame);
  forge(Channel::readout, strobe_msgs::readout_t{});
  for (int i = 0; i < 200; ++i) {
    pass(loop, 0.02);
    runner.step();
  }
  LONGS_EQUAL(0, bus.sent.size());
  LONGS_EQUAL(0, results.results.size());
  CHECK_FALSE(loop.session().status().has_value());
  LONGS_EQUAL(0, loop.session().ledger().received() + loop.session().ledger().missing());
  using authentication::Unverified;
  LONGS_EQUAL(5, loop.unverified()[Unverified::unsealed]);
  LONGS_EQUAL(5, loop.unverified()[Unverified::other_key]);
  LONGS_EQUAL(15 - 1, loop.unverified()[Unverified::altered]);  // the readout's own channel is its own
  LONGS_EQUAL(1, results.notifications.size());
  STRCMP_CONTAINS(
      "packets ignored that are not the lab's: 5 not sealed, 5 sealed with another key, 14 altered",
      results.notifications[0].c_str());
}

TEST(HostLoop, ActsOnEachPacketOnce) {
  HostLoop loop(settings(true), bus, clock);
  loop.add_listener(results);
  arrive(Channel::status, idle_status());
  const auto old_status = bus.arriving.back();
  pass(loop, 0.02);
  const HostTime heard = loop.session().status_heard();
  for (int i = 0; i < 100; ++i) {
    bus.arriving.push_back(old_status);
    pass(loop, 0.1);
  }
  CHECK_EQUAL(heard, loop.session().status_heard());
  CHECK_FALSE(loop.live_status().has_value());
  LONGS_EQUAL(100, loop.unverified()[authentication::Unverified::replayed]);
  LONGS_EQUAL(0, results.notifications.size());  // networks repeat packets, too
}

TEST(HostLoop, TellsOfStrangersInALineInTenSecondsHoweverManyTheyAre) {
  HostLoop loop(settings(false), bus, clock);
  loop.add_listener(results);
  for (int second = 0; second < 100; ++second) {
    for (int i = 0; i < 800; ++i) {
      event_t event{};
      event.schema_version = event_t::SCHEMA_VERSION;
      event.boot_id = 1 + second * 800 + i;
      event.sequence = 1;
      event.kind = event_t::REPAIRED;
      bus.arriving.emplace_back(channel(Channel::event), messages::encode(event));
    }
    pass(loop, 1.0);
  }
  LONGS_EQUAL(80'000, loop.unverified()[authentication::Unverified::unsealed]);
  LONGS_EQUAL(10, results.notifications.size());
  LONGS_EQUAL(0, bus.sent.size());
}

TEST(HostLoop, WithoutAKeyShowsWhateverComesAsUnverified) {
  HostLoop loop(settings(false, false), bus, clock);
  loop.add_listener(results);
  made.shot.first_sequence = made.shot.last_sequence = 0;
  bus.arriving.emplace_back(channel(Channel::shot), messages::encode(made.shot));
  arrive(Channel::frame, made.frame);  // sealed: read all the same
  pass(loop, 0.02);
  LONGS_EQUAL(1, results.results.size());
  CHECK_FALSE(results.results[0].verified);
  CHECK_FALSE(loop.verifies());
  LONGS_EQUAL(0, bus.sent.size());
}

TEST(HostLoop, UsesNoFrameThatMayBeOfAnySession) {
  HostLoop loop(settings(true), bus, clock);
  loop.add_listener(results);
  made.shot.host_id = kHost;
  made.shot.first_sequence = made.shot.last_sequence = 0;
  arrive(Channel::shot, made.shot);
  strobe_msgs::frame_t anywhere = made.frame;
  anywhere.boot_id = 0;
  arrive(Channel::frame, anywhere);
  pass(loop, 0.02);
  LONGS_EQUAL(0, results.results.size());
  LONGS_EQUAL(1, results.notifications.size());
  arrive(Channel::frame, made.frame);
  pass(loop, 0.02);
  LONGS_EQUAL(1, results.results.size());
  CHECK_TRUE(results.results[0].verified);
}

TEST(HostLoop, TimesInTheLogGoOnWhenTheWallClockIsSet) {
  testing::TemporaryFolder folder;
  auto session = host::SessionFolder::open(folder.path(), "20260131T093000Z", "", "");
  clock.wall_ahead = std::chrono::hours{1000};
  host::LoggedTransport transport(bus, **session, clock);
  const Duration start = clock.now + clock.wall_ahead;
  for (const int hours : {1000, 1001, 900}) {
    clock.wall_ahead = std::chrono::hours{hours};
    transport.publish(channel(Channel::status), messages::encode(idle_status()));
    clock.now += milliseconds{500};
  }
  lcm::LogFile log((folder / "host-20260131T093000Z.lcmlog").string(), "r");
  for (int i = 0; i < 3; ++i)
    CHECK_EQUAL(start + i * milliseconds{500}, Duration{microseconds{log.readNextEvent()->timestamp}});
}
