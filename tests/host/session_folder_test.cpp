// What is kept of a session, and what a second run in the same folder makes of it.
#include "host/session/session_folder.hpp"

#include <algorithm>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <vector>

#include "tests/support/sealed_sender.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using host::EventLedger;
using host::SessionFolder;
using testing::read_text;
using testing::TemporaryFolder;

constexpr const char* kUtc = "20260131T093000Z";

const authentication::Key kKey = authentication::Key::random();
constexpr const char* kEvents = "STROBE/bench/EVENT";

strobe_msgs::event_t event_of(std::int64_t sequence) {
  strobe_msgs::event_t event{};
  event.boot_id = 77;
  event.sequence = sequence;
  return event;
}

}  // namespace

TEST_GROUP(FolderOfASession){};

TEST(FolderOfASession, KeepsEveryMessageAsItCame) {
  TemporaryFolder folder;
  const auto path = folder / "a/b";
  const std::string bytes("\0\1binary\xff", 9);
  {
    auto session = SessionFolder::open(path, kUtc, "rig = \"bench\"\n", "train = \"free\"\n",
                                       {"my_camera.toml", "px_per_m = 9\n"});
    CHECK_TRUE(session.has_value());
    (*session)->log("STROBE/bench/EVENT", {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()},
                    WallTime{microseconds{1'000'001}});
    // Read while still open, as after a kill: nothing may be left in a buffer.
    lcm::LogFile log((path / "host-20260131T093000Z.lcmlog").string(), "r");
    const lcm::LogEvent* event = log.readNextEvent();
    CHECK_TRUE(event != nullptr);
    CHECK_EQUAL("STROBE/bench/EVENT", event->channel);
    LONGS_EQUAL(1'000'001, event->timestamp);
    LONGS_EQUAL(bytes.size(), event->datalen);
    MEMCMP_EQUAL(bytes.data(), event->data, bytes.size());
    CHECK_TRUE(log.readNextEvent() == nullptr);
  }
  CHECK_EQUAL("rig = \"bench\"\n", read_text(path / "rig.toml"));
  CHECK_EQUAL("train = \"free\"\n", read_text(path / "plan.toml"));
  CHECK_EQUAL("px_per_m = 9\n", read_text(path / "my_camera.toml"));
}

TEST(FolderOfASession, ASecondRunOverwritesNothing) {
  TemporaryFolder folder;
  for (const char* rig : {"rig = \"one\"\n", "rig = \"one\"\n", "rig = \"two\"\n"})
    CHECK_TRUE(SessionFolder::open(folder.path(), kUtc, rig, "").has_value());
  CHECK_EQUAL("rig = \"one\"\n", read_text(folder / "rig.toml"));
  CHECK_EQUAL("rig = \"two\"\n", read_text(folder / "rig-20260131T093000Z.toml"));
  for (const char* log :
       {"host-20260131T093000Z.lcmlog", "host-20260131T093000Zb.lcmlog", "host-20260131T093000Zc.lcmlog"})
    CHECK_TRUE_TEXT(std::filesystem::exists(folder / log), log);
}

TEST(FolderOfASession, EventsOfEarlierRunsAreNotAskedForAgain) {
  TemporaryFolder folder;
  testing::SealedSender lab{kKey};
  {
    auto first = SessionFolder::open(folder.path(), kUtc, "", "");
    const auto log = [&first](const char* channel, const std::vector<std::uint8_t>& bytes) {
      (*first)->log(channel, bytes, {});
    };
    for (const std::int64_t sequence : {1, 2, 4}) log(kEvents, lab.packet(kEvents, event_of(sequence)));
    log("STROBE/other/EVENT", lab.packet("STROBE/other/EVENT", event_of(3)));
    log(kEvents, {1, 2, 3});
    // What a host without the key has kept may be anybody's.
    log(kEvents, messages::encode(event_of(3)));
    // its last field, an empty text with its end, says that it is -1 bytes long
    auto hostile = messages::encode(event_of(3));
    std::fill(hostile.end() - 5, hostile.end() - 1, std::uint8_t{0xff});
    log(kEvents, lab.packet(kEvents, authentication::Bytes(hostile)));
  }
  auto second = SessionFolder::open(folder.path(), kUtc, "", "");
  EventLedger ledger(true);
  (*second)->load_events(ledger, "bench", kKey);
  ledger.status(77, 4, {});
  LONGS_EQUAL(3, ledger.received());
  LONGS_EQUAL(1, ledger.missing());
}

TEST(FolderOfASession, ASummaryThatAnEarlierRunDidNotGetIsAskedFor) {
  TemporaryFolder folder;
  testing::SealedSender lab{kKey};
  {
    auto first = SessionFolder::open(folder.path(), kUtc, "", "");
    for (const std::int64_t sequence : {1, 2}) {
      strobe_msgs::event_t event = event_of(sequence);
      event.kind = strobe_msgs::event_t::SHOT_ENDED;
      event.shot_id = static_cast<std::int32_t>(sequence);
      const auto bytes = lab.packet(kEvents, event);
      (*first)->log("STROBE/bench/EVENT", bytes, from_ns<WallTime>(sequence));
    }
    strobe_msgs::shot_t shot{};
    shot.boot_id = 77;
    shot.shot_id = 1;
    const auto bytes = lab.packet("STROBE/bench/SHOT", shot);
    (*first)->log("STROBE/bench/SHOT", bytes, {});
  }
  auto second = SessionFolder::open(folder.path(), kUtc, "", "");
  EventLedger ledger(true);
  (*second)->load_events(ledger, "bench", kKey);
  ledger.status(77, 2, {});
  const auto asks = ledger.due(HostTime{milliseconds{1000}});
  LONGS_EQUAL(1, asks.size());
  LONGS_EQUAL(2, asks[0].sequences.first);
}

TEST(FolderOfASession, AFolderThatCannotBeMadeIsNamed) {
  const auto session = SessionFolder::open("/proc/nowhere", kUtc, "", "");
  CHECK_FALSE(session.has_value());
  STRCMP_CONTAINS("/proc/nowhere", session.error().message.c_str());
}

TEST(FolderOfASession, TimesAreUtc) {
  // 2026-01-31 09:30:00.123 UTC is 1769851800.123 s after 1970 (date -u -d @1769851800).
  CHECK_EQUAL("20260131T093000Z", host::utc_for_file(WallTime{milliseconds{1'769'851'800'123}}));
  CHECK_EQUAL("2026-01-31T09:30:00.123Z", host::utc_for_table(WallTime{milliseconds{1'769'851'800'123}}));
}
