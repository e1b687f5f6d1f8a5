#include "firmware/publisher/receiver.hpp"

#include <limits>
#include <random>
#include <string>
#include <vector>

#include "common/authentication/seal.hpp"
#include "common/messages/plan_lcm.hpp"
#include "firmware/linux/event_fd.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::firmware;
using authentication::Key;
using authentication::Rejection;
using Type = strobe_msgs::command_t;
using Bytes = std::vector<std::uint8_t>;

namespace {

class StandingClock final : public Clock {
 public:
  MonoTime now() noexcept override { return now_; }
  MonoTime spin_until(MonoTime instant) noexcept override { return instant; }
  void pass(Duration time) { now_ = now_ + time; }

 private:
  MonoTime now_ = from_ns(1);
};

constexpr std::int64_t kBoot = 4711;

Rig small_rig() {
  Rig rig;
  rig.plan.period = microseconds(3000);
  rig.plan.exposure = milliseconds(500);
  rig.plan.impact_at = milliseconds(250);
  return rig;
}

}  // namespace

TEST_GROUP(Receiver) {
  Rig rig = small_rig();
  EventFd wake;
  CommandQueue commands{wake};
  Mailbox mailbox;
  StandingClock clock;
  std::vector<std::string> said;
  Rejections rejections{clock, [this](const std::string& line) { said.push_back(line); }};
  Key key = Key::random();
  std::int64_t boot_time_ns = 50'000'000'000;
  Receiver receiver{rig, kBoot, key, commands, mailbox, rejections, [this] { return boot_time_ns; }};
  Type message{};
  Command command;

  void setup() override {
    message.schema_version = Type::SCHEMA_VERSION;
    message.host_id = 5;
    message.command_id = 1;
    message.boot_id = kBoot;
    message.kind = Type::ARM;
    message.sent_boot_time_ns = boot_time_ns;
  }
  void fill_fire() {
    message.kind = Type::FIRE;
    message.arm_token = 99;
    message.plan = messages::plan_to_lcm(rig.plan);
  }
  void note(const std::string& key_of_note, const std::string& value) {
    message.notes.emplace_back();
    message.notes.back().key = key_of_note;
    message.notes.back().value = value;
    message.note_count = static_cast<std::int32_t>(message.notes.size());
  }
  Bytes body() const {
    Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
  }
  Bytes sealed() const { return authentication::seal(key, rig.name, body()).value(); }
  /// Whether the loop got a command.
  bool deliver(const Bytes& bytes) {
    receiver.receive(bytes);
    return commands.pop(command);
  }
  bool deliver() { return deliver(sealed()); }
  void expect_rejected(Rejection why, const Bytes& bytes) {
    const std::int64_t before = rejections.count(why);
    CHECK_FALSE(deliver(bytes));
    LONGS_EQUAL(before + 1, rejections.count(why));
    CHECK_FALSE(mailbox.next_resend().has_value());
  }
  std::string defect() const { return std::string(command.defect.view()); }
};

TEST(Receiver, WakesTheLoopWithACommand) {
  CHECK_TRUE(deliver());
  CHECK_EQUAL(CommandKind::arm, command.kind);
  CHECK_EQUAL(5, command.host_id);
  CHECK_EQUAL(std::string(), defect());
  CHECK_EQUAL(1u, wake.take());
}

TEST(Receiver, TellsTheLoopWhoArms) {
  note("host_name", "anna@desk");
  CHECK_TRUE(deliver());
  CHECK_EQUAL("anna@desk", std::string(command.host_name.view()));
}

TEST(Receiver, TakesANameForOneWordOfAtMost64BytesOrLeavesItOut) {
  note("host_name", "anna maria\n" + std::string(100, 'x'));
  CHECK_TRUE(deliver());
  CHECK_EQUAL("anna_maria_" + std::string(53, 'x'), std::string(command.host_name.view()));
  message.notes.front().value = std::string(2000, 'x');
  ++message.command_id;
  CHECK_TRUE(deliver());
  CHECK_TRUE(command.host_name.empty());
  CHECK_EQUAL(std::string(), defect());
}

TEST(Receiver, DoesNotCallACommandDroppedThatALoopWhichCannotBeWokenWillTake) {
  close(wake.fd());
  CHECK_TRUE(deliver());
  CHECK_TRUE(said.empty());
}

TEST(Receiver, TellsThatACommandWasDroppedWhenTheLoopTakesNone) {
  for (; said.empty() && message.command_id < 10'000; ++message.command_id) receiver.receive(sealed());
  CHECK_EQUAL(std::string("a command was dropped: too many at once"), said.front());
  // Those before it are kept.
  for (std::int64_t kept = 1; kept < message.command_id - 1; ++kept) {
    CHECK_TRUE(commands.pop(command));
    CHECK_EQUAL(kept, command.command_id);
  }
  CHECK_FALSE(commands.pop(command));
}

TEST(Receiver, GivesEachArmATokenOfItsOwn) {
  CHECK_TRUE(deliver());
  const std::int64_t first = command.new_token;
  ++message.command_id;
  CHECK_TRUE(deliver());
  CHECK(first != 0);
  CHECK(command.new_token != 0);
  CHECK(command.new_token != first);
}

TEST(Receiver, IgnoresCommandsForAnotherBoot) {
  message.boot_id = kBoot + 1;
  expect_rejected(Rejection::stale, sealed());
  message.kind = Type::RESEND;
  expect_rejected(Rejection::stale, sealed());
}

TEST(Receiver, IgnoresARepeatedCommand) {
  CHECK_TRUE(deliver());
  expect_rejected(Rejection::replayed, sealed());
  message.command_id = 0;
  expect_rejected(Rejection::replayed, sealed());
  message.host_id = 6;  // each host counts for itself
  CHECK_TRUE(deliver());
}

TEST(Receiver, IgnoresAStranger) {
  expect_rejected(Rejection::forged, authentication::seal(Key::random(), rig.name, body()).value());
}

TEST(Receiver, IgnoresACommandThatWasAlteredOnItsWay) {
  Bytes bytes = sealed();
  bytes[bytes.size() / 2] ^= 1;
  expect_rejected(Rejection::forged, bytes);
}

TEST(Receiver, IgnoresACommandForAnotherRigOfTheLab) {
  expect_rejected(Rejection::other_rig, authentication::seal(key, "pitch", body()).value());
}

TEST(Receiver, IgnoresABareCommand) { expect_rejected(Rejection::malformed, body()); }

TEST(Receiver, IgnoresWhatIsTooLargeForACommand) {
  expect_rejected(Rejection::oversized, Bytes(authentication::kMaxSealed_bytes + 1));
}

TEST(Receiver, IgnoresABodyThatIsNoCommand) {
  Bytes bytes = body();
  bytes.pop_back();
  expect_rejected(Rejection::malformed, authentication::seal(key, rig.name, bytes).value());
  message.kind = Type::RESET + 1;
  expect_rejected(Rejection::malformed, sealed());
}

TEST(Receiver, IsNotDeafenedByWhatAStrangerClaims) {
  message.command_id = 1000;  // of this very host
  expect_rejected(Rejection::forged, authentication::seal(Key::random(), rig.name, body()).value());
  message.command_id = 1;
  CHECK_TRUE(deliver());
}

TEST(Receiver, TakesAPlanAndKeepsItsNotes) {
  fill_fire();
  note("operator", "M");
  note(std::string(64, 'k'), std::string(1024, 'v'));  // the longest
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
  CHECK_EQUAL(1, command.command_id);
  CHECK_EQUAL(0, command.new_token);
  CHECK_EQUAL(rig.plan.period, command.plan.period);
  CHECK_EQUAL(99, command.token);
  const auto notes = mailbox.take(5, 1);
  CHECK_EQUAL(2u, notes.size());
  CHECK_EQUAL(std::string("M"), notes[0].value);
  CHECK_EQUAL(0u, mailbox.take(5, 1).size());
}

TEST(Receiver, FindsWhatIsWrongWithAFire) {
  struct Row {
    void (*corrupt)(Type&);
    const char* defect;
  };
  const Row rows[] = {
      {[](Type& m) { m.schema_version = 3; }, "schema version 3 instead of 2"},
      {[](Type& m) { m.host_id = 0; }, "names no host"},
      {[](Type& m) { m.plan.period_ns = 1'000'000; }, "shorter than the lamps'"},
      {[](Type& m) { m.plan.period_ns = INT64_MIN; }, "period_us is not from 0 to 1 h"},
      {[](Type& m) { m.plan.shutter_open_ns = INT64_MAX; }, "shutter_open_ms is not from 0 to 1 h"},
      {[](Type& m) { m.plan.train = 3; }, "unknown kind of train"},
      {[](Type& m) {
         m.notes.resize(1);
         m.note_count = 1;
         m.notes[0].key = "no spaces";
       },
       "note's key"},
      {[](Type& m) {
         m.notes.resize(1);
         m.note_count = 1;
         m.notes[0].key = std::string(1, 'a');
         m.notes[0].value.assign(1025, 'x');
       },
       "note's key, length or text"},
      {[](Type& m) {
         m.notes.resize(1);
         m.note_count = 1;
         m.notes[0].key.assign(65, 'a');
       },
       "note's key, length or text"},
      {[](Type& m) {
         m.notes.resize(1);
         m.note_count = 1;
         m.notes[0].key = "a";
         m.notes[0].value = "\xED\xA1\xDA\x01";  // a record's beginning
       },
       "note's key, length or text"},
  };
  for (const Row& row : rows) {
    const std::int64_t id = message.command_id;
    message = Type{};
    setup();
    message.command_id = id + 1;
    fill_fire();
    row.corrupt(message);
    CHECK_TRUE(deliver());
    STRCMP_CONTAINS(row.defect, defect().c_str());
    CHECK_EQUAL(0u, mailbox.take(5, id + 1).size());
  }
}

TEST(Receiver, RefusesWhatIsOlderThanASecondWithTheReason) {
  for (const std::int8_t kind : {Type::ARM, Type::FIRE, Type::CLEAR}) {
    fill_fire();
    message.kind = kind;
    for (const std::int64_t age_ms : {0, 1000}) {
      boot_time_ns = message.sent_boot_time_ns + age_ms * 1'000'000;
      ++message.command_id;
      CHECK_TRUE(deliver());
      CHECK_EQUAL(std::string(), defect());
    }
    ++boot_time_ns;
    ++message.command_id;
    CHECK_TRUE(deliver());
    CHECK_EQUAL(std::string("it came 1000 ms after it was sent, and is good for 1000 ms"), defect());
    CHECK(command.kind == static_cast<CommandKind>(kind));
  }
}

TEST(Receiver, RefusesWhatWasSentInTheFutureOrAtNoTime) {
  fill_fire();
  message.sent_boot_time_ns = boot_time_ns + 99'999'999;
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
  ++message.sent_boot_time_ns;
  ++message.command_id;
  CHECK_TRUE(deliver());
  STRCMP_CONTAINS("sent in the future", defect().c_str());
  message.sent_boot_time_ns = 0;
  ++message.command_id;
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string("it does not say when it was sent"), defect());
  for (const std::int64_t extreme :
       {-(std::int64_t{1} << 60), std::int64_t{1} << 60, std::numeric_limits<std::int64_t>::min(),
        std::numeric_limits<std::int64_t>::max()}) {
    message.sent_boot_time_ns = extreme;
    ++message.command_id;
    CHECK_TRUE(deliver());
    CHECK_FALSE(defect().empty());
  }
}

TEST(Receiver, HearsADisarmHoweverOldItIs) {
  message.kind = Type::DISARM;
  boot_time_ns += 3'600'000'000'000;
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
}

TEST(Receiver, PassesAResendToThePublisher) {
  message.kind = Type::RESEND;
  message.resend_boot_id = kBoot;
  message.resend_first = 3;
  message.resend_last = 8;
  CHECK_FALSE(deliver());
  CHECK_FALSE(deliver());      // repeated
  message.resend_boot_id = 1;  // an earlier boot of the session
  ++message.command_id;
  CHECK_FALSE(deliver());
  CHECK(mailbox.next_resend() == EventRange({kBoot, {3, 8}}));
  CHECK(mailbox.next_resend() == EventRange({1, {3, 8}}));
  CHECK_FALSE(mailbox.next_resend().has_value());
}

TEST(Receiver, LosesACommandRatherThanWaitForTheLoop) {
  for (int i = 0; i < 1000; ++i) {
    Command one;
    if (!commands.push(one)) return;
  }
  FAIL("the queue has no end");
}

TEST(Receiver, IgnoresAMessageWithMoreThan64Notes) {
  fill_fire();
  for (int i = 0; i < 64; ++i) note("key", "value");
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
  ++message.command_id;
  note("key", "value");
  expect_rejected(Rejection::malformed, sealed());
}

TEST(Receiver, SurvivesAnyBodyUnderAGoodSeal) {
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  fill_fire();
  note("operator", "M");
  const Bytes good = body();
  for (int trial = 0; trial < 20'000; ++trial) {
    Bytes bytes = good;
    bytes.resize(random() % (good.size() + 1));
    for (int k = 0; k < 3 && bytes.size() > 8; ++k)
      bytes[8 + random() % (bytes.size() - 8)] ^= static_cast<std::uint8_t>(random());
    receiver.receive(authentication::seal(key, rig.name, bytes).value());
    while (commands.pop(command))
      CHECK_TEXT(command.defect.view().size() <= 160, std::to_string(seed).c_str());
  }
}

TEST_GROUP(Mailbox) { Mailbox mailbox; };

TEST(Mailbox, KeepsTheNotesOfTheLast64Commands) {
  for (std::int64_t id = 0; id <= 64; ++id) mailbox.keep({5, id, {{"id", std::to_string(id)}}});
  CHECK_TRUE(mailbox.take(5, 0).empty());
  CHECK_TRUE(mailbox.take(6, 7).empty());
  for (std::int64_t id = 1; id <= 64; ++id) CHECK_EQUAL(std::to_string(id), mailbox.take(5, id).at(0).value);
}

TEST_GROUP(RepetitionFilter){};

TEST(RepetitionFilter, ForgetsNoHostAndRefusesOneTooMany) {
  RepetitionFilter filter;
  constexpr auto kMax = static_cast<std::int64_t>(RepetitionFilter::kMaxHosts);
  for (std::int64_t host = 1; host <= kMax; ++host) CHECK_TRUE(filter.is_new(host, 10));
  CHECK_FALSE(filter.is_new(kMax + 1, 10));
  CHECK_FALSE(filter.is_new(1, 10));
  CHECK_TRUE(filter.is_new(1, 11));
}

TEST_GROUP(Rejections) {
  StandingClock clock;
  std::vector<std::string> said;
  Rejections rejections{clock, [this](const std::string& line) { said.push_back(line); }};
};

TEST(Rejections, AreToldAtOnceThenOnceInTenSeconds) {
  rejections.turn();
  LONGS_EQUAL(0, said.size());
  rejections.note(Rejection::malformed);
  LONGS_EQUAL(1, said.size());
  CHECK_EQUAL("commands ignored: 1 malformed", said[0]);
  for (int i = 0; i < 1'000'000; ++i) {
    rejections.note(i % 4 == 0 ? Rejection::replayed : Rejection::forged);
    clock.pass(microseconds(30));
  }
  LONGS_EQUAL(3, said.size());  // 30 s, but for a little
  clock.pass(Rejections::kQuiet);
  rejections.turn();
  LONGS_EQUAL(4, said.size());
  STRCMP_CONTAINS("forged", said[3].c_str());
  STRCMP_CONTAINS("replayed", said[3].c_str());
  STRCMP_CONTAINS("(has that host this lab's key?)", said[3].c_str());
  clock.pass(Rejections::kQuiet);
  rejections.turn();
  LONGS_EQUAL(4, said.size());  // nothing new
  LONGS_EQUAL(1, rejections.count(Rejection::malformed));
  LONGS_EQUAL(750'000, rejections.count(Rejection::forged));
  LONGS_EQUAL(250'000, rejections.count(Rejection::replayed));
}
