#include "firmware/publisher/receiver.hpp"

#include <random>
#include <string>

#include "firmware/linux/event_fd.hpp"
// CppUTest redefines new; its headers come last.
#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::firmware;
using Type = strobe_msgs::command_t;

namespace {

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
  Receiver receiver{rig, kBoot, commands, mailbox};
  Type message{};
  Command command;

  void setup() override {
    message.schema_version = Type::SCHEMA_VERSION;
    message.host_id = 5;
    message.command_id = 1;
    message.boot_id = kBoot;
    message.kind = Type::ARM;
  }
  void fill_fire() {
    message.kind = Type::FIRE;
    message.arm_token = 99;
    message.plan = to_message(rig.plan);
  }
  void note(const std::string& key, const std::string& value) {
    message.notes.emplace_back();
    message.notes.back().key = key;
    message.notes.back().value = value;
    message.note_count = static_cast<std::int32_t>(message.notes.size());
  }
  /// Whether the loop got a command.
  bool deliver() {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    receiver.receive(bytes.data(), static_cast<int>(bytes.size()));
    return commands.pop(command);
  }
  std::string defect() const { return std::string(command.defect.view()); }
};

TEST(Receiver, WakesTheLoopWithACommand) {
  CHECK_TRUE(deliver());
  CHECK(command.kind == CommandKind::arm);
  CHECK_EQUAL(5, command.host_id);
  CHECK_EQUAL(std::string(), defect());
  CHECK_EQUAL(1u, wake.take());
}

TEST(Receiver, GivesEachArmATokenOfItsOwn) {
  CHECK_TRUE(deliver());
  const std::int64_t first = command.fresh_token;
  ++message.command_id;
  CHECK_TRUE(deliver());
  CHECK(first != 0);
  CHECK(command.fresh_token != 0);
  CHECK(command.fresh_token != first);
}

TEST(Receiver, IgnoresCommandsForAnotherBoot) {
  message.boot_id = kBoot + 1;
  CHECK_FALSE(deliver());
}

TEST(Receiver, MarksARepeatedCommand) {
  CHECK_TRUE(deliver());
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string("a repeated command"), defect());
  message.command_id = 0;
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string("a repeated command"), defect());
  message.host_id = 6;  // each host counts for itself
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
}

TEST(Receiver, TakesAPlanAndKeepsItsNotes) {
  fill_fire();
  note("operator", "M");
  CHECK_TRUE(deliver());
  CHECK_EQUAL(std::string(), defect());
  CHECK(command.plan.period == rig.plan.period);
  CHECK_EQUAL(99, command.token);
  const auto notes = mailbox.take(5, 1);
  CHECK_EQUAL(1u, notes.size());
  CHECK_EQUAL(std::string("M"), notes[0].value);
  CHECK_EQUAL(0u, mailbox.take(5, 1).size());
}

TEST(Receiver, FindsWhatIsWrongWithAFire) {
  struct Row {
    void (*spoil)(Type&);
    const char* defect;
  };
  const Row rows[] = {
      {[](Type& m) { m.schema_version = 2; }, "schema version 2 instead of 1"},
      {[](Type& m) { m.host_id = 0; }, "names no host"},
      {[](Type& m) { m.plan.period_ns = 1'000'000; }, "shorter than the lamps'"},
      {[](Type& m) { m.plan.period_ns = INT64_MIN; }, "negative or absurdly large"},
      {[](Type& m) { m.plan.shutter_open_ns = INT64_MAX; }, "negative or absurdly large"},
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
       "note's key or length"},
  };
  for (const Row& row : rows) {
    const std::int64_t id = message.command_id;
    message = Type{};
    setup();
    message.command_id = id + 1;
    fill_fire();
    row.spoil(message);
    CHECK_TRUE(deliver());
    STRCMP_CONTAINS(row.defect, defect().c_str());
  }
}

TEST(Receiver, PassesAResendToThePublisher) {
  message.kind = Type::RESEND;
  message.resend_first = 3;
  message.resend_last = 8;
  CHECK_FALSE(deliver());
  CHECK_FALSE(deliver());  // repeated
  message.boot_id = 1;     // an earlier boot of the session
  ++message.command_id;
  CHECK_FALSE(deliver());
  const auto requests = mailbox.requests();
  CHECK_EQUAL(2u, requests.size());
  CHECK_EQUAL(3, requests[0].wanted.first);
  CHECK_EQUAL(8, requests[0].wanted.last);
  CHECK_EQUAL(1, requests[1].boot_id);
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
  CHECK_FALSE(deliver());
}

TEST(Receiver, SurvivesAnyBytes) {
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  fill_fire();
  note("operator", "M");
  std::vector<std::uint8_t> good(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(good.data(), 0, static_cast<int>(good.size()));
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<std::uint8_t> bytes = good;
    bytes.resize(random() % (good.size() + 1));
    for (int k = 0; k < 3 && bytes.size() > 8; ++k)
      bytes[8 + random() % (bytes.size() - 8)] ^= static_cast<std::uint8_t>(random());
    receiver.receive(bytes.data(), static_cast<int>(bytes.size()));
    while (commands.pop(command)) {
      CHECK_TEXT(command.defect.view().size() <= 160, std::to_string(seed).c_str());
    }
  }
}

TEST_GROUP(RepetitionFilter){};

TEST(RepetitionFilter, ForgetsTheHostThatWasSilentLongestWhenItIsFull) {
  RepetitionFilter filter;
  for (std::int64_t host = 1; host <= 4096; ++host) CHECK_TRUE(filter.is_news(host, 10));
  CHECK_TRUE(filter.is_news(1, 11));  // host 2 is now the oldest
  CHECK_TRUE(filter.is_news(5000, 10));
  CHECK_FALSE(filter.is_news(1, 11));
  CHECK_FALSE(filter.is_news(3, 10));
}
