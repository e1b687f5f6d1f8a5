// The observer itself: each thing that must hold is violated on purpose once, and is heard of.
#include "tests/soak/observer.hpp"

#include <fstream>
#include <strobe_msgs/command_t.hpp>
#include <strobe_msgs/event_t.hpp>

#include "firmware/publisher/journal.hpp"
#include "tests/soak/disk.hpp"
// CppUTest redefines new; its headers come last.
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
  command_t message{};
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

TEST_GROUP(Observer) {
  firmware::Rig rig;
  Observer observer{rig};
  MonoTime now{1'000'000'000};

  void setup() override { observer.booted(kBoot); }
  void pass(Duration duration) { now = now + duration; }
  void arm(std::int64_t host = kHost) {
    observer.at_firmware(command(command_t::ARM, 0, host), now);
    observer.token_drawn(kToken, now);
  }
  void fire(std::int64_t token = kToken, std::int64_t host = kHost) {
    pass(milliseconds(1));
    observer.at_firmware(command(command_t::FIRE, token, host), now);
    pass(milliseconds(20));
  }
  void pulse(Output output, Duration width) {
    observer.output(output, true, now);
    pass(width);
    observer.output(output, false, now);
  }
  void trigger() { pulse(Output::trigger, milliseconds(20)); }
  void expect(const char* violation) {
    LONGS_EQUAL(1, observer.violations().size());
    STRCMP_CONTAINS(violation, observer.violations()[0].c_str());
  }
  void expect_none() {
    for (const std::string& violation : observer.violations()) FAIL(violation.c_str());
  }
};

TEST(Observer, AcceptsAShotThatWasArmedAndFired) {
  arm();
  fire();
  trigger();
  pulse(Output::shutter, milliseconds(500));
  expect_none();
  LONGS_EQUAL(1, observer.triggers());
}

TEST(Observer, HearsOfATriggerWithoutAToken) {
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfATriggerWithATokenThatWasNeverGiven) {
  arm();
  fire(kToken + 1);
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfATriggerWithAnotherHostsToken) {
  arm();
  fire(kToken, kHost + 1);
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfASecondTriggerForOneToken) {
  arm();
  fire();
  trigger();
  pass(milliseconds(100));
  fire();
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfATriggerWithTheTokenOfAnEarlierBoot) {
  arm();
  observer.booted(kBoot + 1);
  fire();
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfATriggerLongAfterTheArming) {
  arm();
  pass(milliseconds(31'000));
  fire();
  trigger();
  expect("without a fresh token");
}

TEST(Observer, HearsOfATriggerWithTheKeyOff) {
  arm();
  fire();
  observer.key(false, now);
  pass(microseconds(3));
  observer.output(Output::trigger, true, now);
  expect("with the key off");
}

TEST(Observer, HearsOfAnOutputThatOutlastsTheEStop) {
  arm();
  fire();
  observer.output(Output::shutter, true, now);
  pass(milliseconds(10));
  observer.estop(true, now);
  observer.estop(false, now + microseconds(10));  // however short it was
  pass(microseconds(1001));
  observer.output(Output::shutter, false, now);
  expect("inactive only 1001 us after");
}

TEST(Observer, DoesNotBlameTheFirmwareForAMachineThatStoodStill) {
  observer.output(Output::shutter, true, now);
  observer.estop(true, now);
  observer.stands_still(now, now + milliseconds(50));
  pass(milliseconds(50));
  observer.output(Output::shutter, false, now);
  expect_none();
}

TEST(Observer, GivesTheGuardianSixMillisecondsAfterTheProcessesEnd) {
  observer.output(Output::shutter, true, now);
  observer.died(now);
  observer.key(false, now);
  pass(milliseconds(6));
  observer.output(Output::shutter, false, now);
  expect_none();
  observer.key(true, now);
  observer.output(Output::shutter, true, now);
  observer.died(now);
  observer.key(false, now);
  pass(milliseconds(8));
  observer.output(Output::shutter, false, now);
  expect("inactive only");
}

TEST(Observer, HearsOfAnOutputThatBecomesActiveWhileTheEStopIsPressed) {
  observer.estop(true, now);
  pass(milliseconds(2));
  pulse(Output::strobes, microseconds(50));
  expect("lamps made active");
}

TEST(Observer, HearsOfAnOutputThatIsOnTooLong) {
  arm();
  fire();
  pulse(Output::trigger, rig.machine.max_on + microseconds(200));
  expect("trigger active for");
}

TEST(Observer, HearsOfFlashesTooCloseAndTooMany) {
  pulse(Output::strobes, microseconds(50));
  pass(microseconds(1300));
  pulse(Output::strobes, microseconds(50));
  expect("a lamp flashed 1350 us after");
  for (int k = 2; k <= rig.lamps.max_flashes; ++k) {
    pass(milliseconds(2));
    pulse(Output::strobes, microseconds(50));
  }
  LONGS_EQUAL(2, observer.violations().size());
  STRCMP_CONTAINS("401 flashes in one shot", observer.violations()[1].c_str());
}

TEST(Observer, HearsOfAnOutputThatIsStillActiveInTheEnd) {
  const VirtualDisk disk;
  observer.output(Output::shutter, true, now);
  observer.end(disk.path());
  expect("shutter still active");
}

TEST(Observer, HearsOfEventsThatAreInAJournalAndOnNoHost) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  for (const std::int64_t sequence : {1, 2, 3}) {
    CHECK_TRUE(
        journal
            ->append(
                {{firmware::Message::Kind::event, {sequence, sequence}, "STROBE/x/EVENT", event(sequence)}},
                0)
            .has_value());
  }
  observer.at_host("STROBE/x/EVENT", event(1));
  observer.at_host("STROBE/x/EVENT", event(3));
  observer.end(disk.path());
  expect("event 2 of boot 4d is in the journal and on no host");
  LONGS_EQUAL(3, observer.events_journalled());
  LONGS_EQUAL(1, observer.events_missing());
}

TEST(Observer, HearsOfAJournalWithAGapAndOfATornOne) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  for (const std::int64_t sequence : {1, 3}) {
    CHECK_TRUE(
        journal
            ->append(
                {{firmware::Message::Kind::event, {sequence, sequence}, "STROBE/x/EVENT", event(sequence)}},
                0)
            .has_value());
    observer.at_host("STROBE/x/EVENT", event(sequence));
  }
  observer.end(disk.path());
  expect("event 3 follows 1");
  std::filesystem::resize_file(journal->path(), std::filesystem::file_size(journal->path()) - 5);
  observer.end(disk.path());
  STRCMP_CONTAINS("torn record", observer.violations().back().c_str());
}

TEST(Observer, HearsOfAShotThatIsReadOutTwice) {
  const reduction::Readout readout;
  observer.readout(kHost, {kBoot, 1}, readout, {}, false);
  observer.readout(kHost + 1, {kBoot, 1}, readout, {}, false);  // another host may
  expect_none();
  observer.readout(kHost, {kBoot, 1}, readout, {}, false);
  expect("read out twice");
}

TEST(Observer, HearsOfAWrongNumberUnlessAFlagExplainsIt) {
  Truth truth;
  truth.value[Quantity::e] = 0.80;
  reduction::Readout readout;
  readout.value[Quantity::e] = 0.80 + 6.5 * 0.01;
  readout.sd[Quantity::e] = 0.01;
  observer.readout(kHost, {kBoot, 1}, readout, truth, false);
  expect_none();
  readout.value[Quantity::e] = 0.80 + 6.7 * 0.01;
  readout.flags.set(Flag::late_flash);
  observer.readout(kHost, {kBoot, 2}, readout, truth, false);
  expect_none();
  readout.flags = {};
  readout.flags.set(Flag::outlier_image);
  observer.readout(kHost, {kBoot, 3}, readout, truth, false);
  expect("wrong without a flag: e = 0.867, true 0.8, 6.7 sd off");
}

TEST_GROUP(Judge){};

TEST(Judge, AllowsSoMuchThatChanceRaisesAFalseAlarmInOneOfAThousandSoaks) {
  // 16e6 comparisons, 1e-3 false alarms: 6.25e-11 of a normal distribution lie beyond 6.54 sd.
  DOUBLES_EQUAL(6.54, soak_limit(), 0.01);
  DOUBLES_EQUAL(1.959964, limit_of(1.0, 0.05), 1e-6);
}

TEST(Judge, FindsANumberOfABallThatNeverCame) {
  reduction::Readout readout;
  readout.value[Quantity::vx_td_mps] = 12.0;
  readout.sd[Quantity::vx_td_mps] = 1.0;
  STRCMP_CONTAINS("vx_td_mps = 12, true none", judge(readout, {}, 6.5).wrong.c_str());
}

TEST(Judge, AddsTheSystematicUncertaintyToTheStatisticalOne) {
  Truth truth;
  truth.value[Quantity::vx_td_mps] = 10.0;
  reduction::Readout readout;
  readout.value[Quantity::vx_td_mps] = 10.5;
  readout.sd[Quantity::vx_td_mps] = 0.03;
  readout.sd_systematic[Quantity::vx_td_mps] = 0.04;
  DOUBLES_EQUAL(10.0, judge(readout, truth, 20.0).largest_z, 1e-9);
}

TEST(Judge, CountsWhatAFlagExplains) {
  Truth truth;
  truth.value[Quantity::omega_lo_radps] = -600.0;
  reduction::Readout readout;
  readout.flags.set(Flag::spin_aliased);
  readout.value[Quantity::omega_lo_radps] = 447.0;
  readout.sd[Quantity::omega_lo_radps] = 1.0;
  const Judgement judgement = judge(readout, truth, 6.5);
  CHECK_TRUE(judgement.wrong.empty());
  LONGS_EQUAL(1, judgement.explained);
  CHECK_TRUE(judgement.by_flag[static_cast<std::size_t>(Flag::spin_aliased)]);
  DOUBLES_EQUAL(0.0, judgement.largest_z, 0.0);
}

TEST(Observer, CountsEventsOfABootThatNoHostHeardOf) {
  const VirtualDisk disk;
  auto journal = firmware::Journal::create(disk.path(), kBoot);
  CHECK_TRUE(
      journal->append({{firmware::Message::Kind::event, {1, 1}, "STROBE/x/EVENT", event(1)}}, 0).has_value());
  observer.end(disk.path());
  expect_none();
  LONGS_EQUAL(1, observer.events_unheard());
}
