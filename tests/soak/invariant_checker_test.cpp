// Each invariant is violated on purpose once, and reported.
#include "tests/soak/invariant_checker.hpp"

#include <functional>
#include <optional>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>

#include "firmware/publisher/journal.hpp"
#include "tests/soak/disk.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::soak;
using firmware::Output;
using reduction::Flag;
using reduction::Quantity;
using strobe_msgs::command_t;

namespace {

constexpr std::int64_t kBoot = 77;
constexpr std::int64_t kHost = 5;
constexpr std::int64_t kToken = 4242;

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

std::vector<std::uint8_t> command(std::int8_t kind, std::int64_t token = 0, std::int64_t host = kHost,
                                  std::int64_t boot = kBoot) {
  static std::int64_t commands = 0;
  command_t message{};
  message.command_id = ++commands;
  message.schema_version = command_t::SCHEMA_VERSION;
  message.boot_id = boot;
  message.host_id = host;
  message.kind = kind;
  message.arm_token = token;
  return encoded(message);
}

std::vector<std::uint8_t> event(std::int64_t sequence) {
  strobe_msgs::event_t message{};
  message.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  message.boot_id = kBoot;
  message.sequence = sequence;
  return encoded(message);
}

}  // namespace

TEST_GROUP(InvariantChecker) {
  firmware::Rig rig;
  std::optional<InvariantChecker> checker;
  MonoTime now = from_ns(1'000'000'000);

  void setup() override { checker.emplace(rig).booted(kBoot); }
  void pass(Duration duration) { now = now + duration; }
  void arm(std::int64_t host = kHost) {
    checker->at_firmware(command(command_t::ARM, 0, host), now);
    checker->token_drawn(kToken, now);
  }
  void fire(std::int64_t token = kToken, std::int64_t host = kHost) {
    pass(milliseconds(1));
    checker->at_firmware(command(command_t::FIRE, token, host), now);
    pass(milliseconds(20));
  }
  void pulse(Output output, Duration width) {
    checker->output(output, true, now);
    pass(width);
    checker->output(output, false, now);
  }
  /// A shot that a person wants, after everything before.
  void act(std::int64_t host = kHost) { checker->acted(host, now); }
  void send(std::int8_t kind, std::int64_t host = kHost) {
    pass(milliseconds(1));
    checker->at_firmware(command(kind, 0, host), now);
  }
  void reset(std::int64_t host = kHost) { send(command_t::RESET, host); }
  void shoot() { arm(), fire(), trigger(); }
  HostTime shown(Duration after) const { return HostTime{} + after; }
  void trigger() { pulse(Output::trigger, milliseconds(20)); }
  void journalled(firmware::Journal & journal, std::int64_t sequence) {
    CHECK_TRUE(
        journal
            .append(
                {{firmware::Message::Kind::event, {sequence, sequence}, "STROBE/x/EVENT", event(sequence)}},
                0)
            .has_value());
  }
  void expect(const char* violation) {
    LONGS_EQUAL(1, checker->violations().size());
    STRCMP_CONTAINS(violation, checker->violations()[0].c_str());
  }
  void expect_none() {
    for (const std::string& violation : checker->violations()) FAIL(violation.c_str());
  }
};

TEST(InvariantChecker, AcceptsAShotThatWasArmedAndFired) {
  arm();
  fire();
  trigger();
  pulse(Output::shutter, milliseconds(500));
  expect_none();
  LONGS_EQUAL(1, checker->triggers());
}

TEST(InvariantChecker, HearsOfATriggerWithoutAFreshToken) {
  const std::function<void()> ways[] = {[] {},
                                        [this] { arm(), fire(kToken + 1); },         // never given
                                        [this] { arm(), fire(kToken, kHost + 1); },  // another host's
                                        [this] { arm(), fire(), trigger(), pass(milliseconds(100)), fire(); },
                                        [this] { arm(), checker->booted(kBoot + 1), fire(); },
                                        [this] { arm(), pass(milliseconds(31'000)), fire(); }};
  for (const auto& way : ways) {
    setup();
    way();
    trigger();
    expect("without a fresh token");
  }
}

TEST(InvariantChecker, HearsOfATriggerWithTheKeyOff) {
  arm();
  fire();
  checker->key(false, now);
  pass(microseconds(3));
  checker->output(Output::trigger, true, now);
  expect("with the key off");
}

TEST(InvariantChecker, HearsOfATriggerAfterAStopOfAnyKindWithoutAnAct) {
  const std::function<void()> stops[] = {
      [this] { checker->key(false, now), checker->key(true, now); },
      [this] { checker->estop(true, now), checker->estop(false, now); },
      [this] { send(command_t::DISARM, kHost + 1); },
      [this] { checker->suspended(now); },
      [this] { checker->stop_asked(kHost + 1, shown({}), now), checker->confirmation_shown(kHost + 1); },
  };
  for (const auto& stop : stops) {
    setup();
    act();
    pass(milliseconds(1));
    stop();
    reset();
    pass(milliseconds(2'000));
    shoot();
    expect("without a person's act since the stop");
    LONGS_EQUAL(1, checker->stops().triggers);
  }
}

TEST(InvariantChecker, AcceptsAShotThatAPersonWantsAfterAStop) {
  send(command_t::DISARM);
  pass(milliseconds(1));
  act();
  reset();
  pass(milliseconds(2'000));
  shoot();
  expect_none();
}

TEST(InvariantChecker, HearsOfATriggerThatFollowsAResetTooSoonOrNone) {
  for (const bool is_reset : {true, false}) {
    setup();
    checker->suspended(now);
    pass(milliseconds(1));
    act();
    if (is_reset) reset();
    pass(milliseconds(900));
    shoot();
    expect("sooner than the restart delay");
  }
}

TEST(InvariantChecker, AsksForAnActAtTheHostThatFires) {
  checker->suspended(now);
  pass(milliseconds(1));
  act(kHost + 1);
  reset(kHost + 1);
  pass(milliseconds(2'000));
  shoot();
  expect("without a person's act");
}

TEST(InvariantChecker, HearsOfAShotThatAHostFiresAfterItsSleep) {
  act();
  checker->host_sleeps(kHost, now + milliseconds(2'000));
  pass(milliseconds(2'000));
  shoot();
  expect("after its sleep");
}

TEST(InvariantChecker, DoesNotTakeADisarmThatWasSentAgainForAStop) {
  const auto old = command(command_t::DISARM);
  checker->at_firmware(old, now);
  pass(milliseconds(1));
  act();
  reset();
  pass(milliseconds(2'000));
  checker->at_firmware(old, now);
  shoot();
  expect_none();
  LONGS_EQUAL(0, checker->stops().reached);
}

TEST(InvariantChecker, HearsOfAStopThatIsNeitherConfirmedNorShownAsADangerWithinASecond) {
  checker->stop_asked(kHost, shown({}), now);
  checker->shows(kHost, false, shown(milliseconds(1'000)));
  expect_none();
  checker->shows(kHost, false, shown(milliseconds(1'001)));
  expect("neither confirmed nor shown as a danger");
}

TEST(InvariantChecker, IsContentWithAStopThatIsConfirmedOrShownAsADangerOrWhoseHostIsGone) {
  const std::function<void()> ends[] = {
      [this] { checker->confirmation_shown(kHost); },
      [this] { checker->shows(kHost, true, shown(milliseconds(900))); },
      [this] { checker->host_gone(kHost); },
  };
  for (const auto& end : ends) {
    setup();
    checker->stop_asked(kHost, shown({}), now);
    end();
    checker->shows(kHost, false, shown(milliseconds(3'000)));
    expect_none();
  }
}

TEST(InvariantChecker, HearsOfAnOutputThatOutlastsTheEStop) {
  arm();
  fire();
  checker->output(Output::shutter, true, now);
  pass(milliseconds(10));
  checker->estop(true, now);
  checker->estop(false, now + microseconds(10));  // however short it was
  pass(microseconds(1001));
  checker->output(Output::shutter, false, now);
  expect("inactive only 1001 us after");
}

TEST(InvariantChecker, DoesNotBlameTheFirmwareForAMachineThatStoodStill) {
  checker->output(Output::shutter, true, now);
  checker->estop(true, now);
  checker->stands_still(now, now + milliseconds(50));
  pass(milliseconds(50));
  checker->output(Output::shutter, false, now);
  expect_none();
}

TEST(InvariantChecker, GivesTheGuardianSixMillisecondsAfterTheProcessesEnd) {
  checker->output(Output::shutter, true, now);
  checker->died(now);
  checker->key(false, now);
  pass(milliseconds(6));
  checker->output(Output::shutter, false, now);
  expect_none();
  checker->key(true, now);
  checker->output(Output::shutter, true, now);
  checker->died(now);
  checker->key(false, now);
  pass(milliseconds(8));
  checker->output(Output::shutter, false, now);
  expect("inactive only");
}

TEST(InvariantChecker, HearsOfAnOutputThatBecomesActiveWhileTheEStopIsPressed) {
  checker->estop(true, now);
  pass(milliseconds(2));
  pulse(Output::strobes, microseconds(50));
  expect("lamps made active");
}

TEST(InvariantChecker, HearsOfAnOutputThatIsOnTooLong) {
  arm();
  fire();
  pulse(Output::trigger, rig.machine.max_on + microseconds(200));
  expect("trigger active for");
}

TEST(InvariantChecker, HearsOfFlashesTooCloseAndTooMany) {
  pulse(Output::strobes, microseconds(50));
  pass(microseconds(1300));
  pulse(Output::strobes, microseconds(50));
  expect("a lamp flashed 1350 us after");
  for (int k = 2; k <= rig.lamps.max_flashes; ++k) {
    pass(milliseconds(2));
    pulse(Output::strobes, microseconds(50));
  }
  LONGS_EQUAL(2, checker->violations().size());
  STRCMP_CONTAINS("401 flashes in one shot", checker->violations()[1].c_str());
}

TEST(InvariantChecker, HearsOfAnOutputThatIsStillActiveInTheEnd) {
  const VirtualDisk disk;
  checker->output(Output::shutter, true, now);
  checker->end(disk.path());
  expect("shutter still active");
}

TEST(InvariantChecker, HearsOfEventsThatAreInAJournalAndOnNoHost) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  for (const std::int64_t sequence : {1, 2, 3}) journalled(*journal, sequence);
  checker->at_host("STROBE/x/EVENT", event(1));
  checker->at_host("STROBE/x/EVENT", event(3));
  checker->end(disk.path());
  expect("event 2 of boot 4d is in the journal and on no host");
  LONGS_EQUAL(3, checker->events_journalled());
  LONGS_EQUAL(1, checker->events_missing());
}

TEST(InvariantChecker, HearsOfAJournalWithAGapAndOfATornOne) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  for (const std::int64_t sequence : {1, 3}) {
    journalled(*journal, sequence);
    checker->at_host("STROBE/x/EVENT", event(sequence));
  }
  checker->end(disk.path());
  expect("event 3 follows 1");
  std::filesystem::resize_file(journal->path(), std::filesystem::file_size(journal->path()) - 5);
  checker->end(disk.path());
  STRCMP_CONTAINS("torn record", checker->violations().back().c_str());
}

TEST(InvariantChecker, HearsOfAShotThatIsReadOutTwice) {
  const reduction::Readout readout;
  checker->readout(kHost, {kBoot, 1}, readout, {}, false);
  checker->readout(kHost + 1, {kBoot, 1}, readout, {}, false);  // another host may
  expect_none();
  checker->readout(kHost, {kBoot, 1}, readout, {}, false);
  expect("read out twice");
}

TEST(InvariantChecker, HearsOfAWrongNumberUnlessAFlagExplainsIt) {
  Truth truth;
  truth.value[Quantity::e] = 0.80;
  reduction::Readout readout;
  readout.value[Quantity::e] = 0.80 + 6.5 * 0.01;
  readout.sd[Quantity::e] = 0.01;
  checker->readout(kHost, {kBoot, 1}, readout, truth, false);
  expect_none();
  readout.value[Quantity::e] = 0.80 + 6.7 * 0.01;
  readout.flags.set(Flag::late_flash);
  checker->readout(kHost, {kBoot, 2}, readout, truth, false);
  expect_none();
  readout.flags = {};
  readout.flags.set(Flag::outlier_image);
  checker->readout(kHost, {kBoot, 3}, readout, truth, false);
  expect("wrong without a flag: e = 0.867, true 0.8, 6.7 sd off");
}

TEST_GROUP(Judge){};

TEST(Judge, AllowsSoMuchThatChanceRaisesAFalseAlarmInOneOfAThousandSoaks) {
  // 16e6 comparisons, 1e-3 false alarms: 6.25e-11 of a normal distribution lie beyond 6.54 sd.
  DOUBLES_EQUAL(6.54, soak_sigma_limit(), 0.01);
  DOUBLES_EQUAL(1.959964, sigma_limit(1.0, 0.05), 1e-6);
}

TEST(Judge, FindsANumberOfABallThatNeverCame) {
  reduction::Readout readout;
  readout.value[Quantity::vx_td_mps] = 12.0;
  readout.sd[Quantity::vx_td_mps] = 1.0;
  STRCMP_CONTAINS("vx_td_mps = 12, true none", compare_with_truth(readout, {}, 6.5).wrong.c_str());
}

TEST(Judge, AddsTheSystematicUncertaintyToTheStatisticalOne) {
  Truth truth;
  truth.value[Quantity::vx_td_mps] = 10.0;
  reduction::Readout readout;
  readout.value[Quantity::vx_td_mps] = 10.5;
  readout.sd[Quantity::vx_td_mps] = 0.03;
  readout.sd_systematic[Quantity::vx_td_mps] = 0.04;
  DOUBLES_EQUAL(10.0, compare_with_truth(readout, truth, 20.0).largest_z, 1e-9);
}

TEST(Judge, CountsWhatAFlagExplains) {
  Truth truth;
  truth.value[Quantity::omega_lo_radps] = -600.0;
  reduction::Readout readout;
  readout.flags.set(Flag::spin_aliased);
  readout.value[Quantity::omega_lo_radps] = 447.0;
  readout.sd[Quantity::omega_lo_radps] = 1.0;
  const TruthComparison comparison = compare_with_truth(readout, truth, 6.5);
  CHECK_TRUE(comparison.wrong.empty());
  LONGS_EQUAL(1, comparison.explained);
  CHECK_TRUE(comparison.by_flag[static_cast<std::size_t>(Flag::spin_aliased)]);
  DOUBLES_EQUAL(0.0, comparison.largest_z, 0.0);
}

TEST(InvariantChecker, CountsEventsOfABootThatNoHostHeardOf) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  journalled(*journal, 1);
  checker->end(disk.path());
  expect_none();
  LONGS_EQUAL(1, checker->events_never_received());
}
