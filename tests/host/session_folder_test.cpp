// What is kept of a session, and what a second run in the same folder makes of it.
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "host/session/session_folder.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::SessionFolder;
using testing::read_text;
using testing::TemporaryFolder;

constexpr const char* kUtc = "20260131T093000Z";

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

TEST(FolderOfASession, KeepsWhatAPersonWasToldAndWhatEachRunWasAskedFor) {
  TemporaryFolder folder;
  for (int run = 1; run <= 2; ++run) {
    auto session =
        SessionFolder::open(folder.path(), kUtc, "", run == 1 ? "period_us = 3000\n" : "period_us = 4000\n");
    (*session)->add_text("09:30 shot " + std::to_string(run) + "\n");
    host::RunRecord record;
    record.host_id = run;
    record.plan_file = (*session)->plan_file();
    (*session)->add(record);
    // Read while still open, as after a kill.
    LONGS_EQUAL(run, host::read_runs(folder / "runs.jsonl")->runs.size());
    (*session)->close();
    CHECK_TRUE((*session)->take_failures().empty());
  }
  CHECK_EQUAL("09:30 shot 1\n09:30 shot 2\n", read_text(folder / "shots.txt"));
  const auto runs = host::read_runs(folder / "runs.jsonl")->runs;
  CHECK_EQUAL("plan.toml", runs.at(0).plan_file);
  CHECK_EQUAL("plan-20260131T093000Z.toml", runs.at(1).plan_file);
  CHECK_EQUAL("period_us = 4000\n", read_text(folder / runs.at(1).plan_file));
}

TEST(FolderOfASession, ARunIsRecordedBehindALineThatAPowerCutTore) {
  TemporaryFolder folder;
  testing::write_text(folder / "runs.jsonl", "{\"host_id\":\"5\",\"sho");
  auto session = SessionFolder::open(folder.path(), kUtc, "", "");
  host::RunRecord record;
  record.host_id = 6;
  (*session)->add(record);
  const auto runs = host::read_runs(folder / "runs.jsonl")->runs;
  LONGS_EQUAL(1, runs.size());
  LONGS_EQUAL(6, runs.front().host_id);
}

TEST(FolderOfASession, ARunThatCannotBeRecordedIsTold) {
  TemporaryFolder folder;
  auto session = SessionFolder::open(folder.path(), kUtc, "", "");
  std::filesystem::create_directory(folder / "runs.jsonl");
  (*session)->add(host::RunRecord{});
  STRCMP_CONTAINS("runs.jsonl: cannot be written", (*session)->take_failures().at(0).c_str());
  STRCMP_CONTAINS("runs.jsonl", (*session)->unstored().at(0).c_str());
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

namespace {

using namespace strobe;
using host::FlashesCsv;
using strobe_msgs::flash_t;
using testing::read_text;
using testing::TemporaryFolder;
using testing::write_text;

strobe_msgs::shot_t example(int shot_id) {
  strobe_msgs::shot_t shot{};
  shot.boot_id = 0x2a;
  shot.shot_id = shot_id;
  flash_t seen{};
  seen.lamps = 3;
  seen.commanded_ns = 1000, seen.issue_start_ns = 1010, seen.issue_end_ns = 1110;
  seen.observed_a_ns = 13'000, seen.observed_b_ns = 13'100;
  flash_t never{};
  never.flash_index = 1;
  never.lamps = 2;
  never.commanded_ns = 4000;
  never.issue_start_ns = never.issue_end_ns = never.observed_a_ns = never.observed_b_ns = flash_t::NO_TIME;
  never.extra_edges = 1;
  shot.flashes = {seen, never}, shot.flash_count = 2;
  return shot;
}

constexpr const char* kOfShotThree =
    "2a,3,0,ab,1000,1010,1110,13000,13100,0\n"
    "2a,3,1,b,4000,,,,,1\n";

}  // namespace

TEST_GROUP(FlashesTable) { TemporaryFolder folder; };

TEST(FlashesTable, HasEachFlashOnALineWithWhatWasNotThereEmpty) {
  auto csv = FlashesCsv::open(folder / "flashes.csv");
  CHECK(csv->add(example(3)).has_value());
  CHECK_EQUAL(host::flashes_header() + "\n" + kOfShotThree, read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, HasEachShotOnceOverSeveralRuns) {
  for (int run = 0; run < 2; ++run) {
    auto csv = FlashesCsv::open(folder / "flashes.csv");
    for (int again = 0; again < 2; ++again) CHECK(csv->add(example(3)).has_value());
  }
  CHECK_EQUAL(host::flashes_header() + "\n" + kOfShotThree, read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, TakesAShotWithoutFlashes) {
  auto csv = FlashesCsv::open(folder / "flashes.csv");
  auto shot = example(4);
  shot.flashes.clear(), shot.flash_count = 0;
  CHECK(csv->add(shot).has_value());
  CHECK_EQUAL(host::flashes_header() + "\n", read_text(folder / "flashes.csv"));
}

TEST(FlashesTable, RefusesAnotherVersionsColumns) {
  write_text(folder / "flashes.csv", "shot,flash\n");
  STRCMP_CONTAINS("another version's columns",
                  FlashesCsv::open(folder / "flashes.csv").error().message.c_str());
}
