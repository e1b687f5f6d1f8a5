// Sessions read back from the folders that hosts wrote, whatever became of host, firmware and photographs.
#include "host/archive/read_session.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <strobe_msgs/readout_t.hpp>

#include "common/authentication/key_file.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::host_test;
using host::StoredSession;
using host::Shot;
using reduction::Flag;
using reduction::Quantity;
namespace fs = std::filesystem;

bool told(const StoredSession& session, const std::string& words) {
  return std::ranges::any_of(session.remarks,
                             [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

std::string all_remarks(const StoredSession& session) {
  std::string text;
  for (const std::string& line : session.remarks) text += line + "\n";
  return text;
}

/// The only log of that start.
fs::path log_at(const fs::path& folder, int second) {
  char name[64];
  std::snprintf(name, sizeof name, "host-20260131T09%02d%02dZ.lcmlog", 30 + second / 60, second % 60);
  return folder / name;
}

}  // namespace

TEST_GROUP(ReadSession) {
  testing::TemporaryFolder place;
  fs::path folder = place / "session";
  fs::path key_file = place / "lab.key";
  authentication::Key key = authentication::make_key_file(key_file).value().key;

  StoredSession read() {
    auto session =
        host::read_session(folder, {.rig_path = "", .key_file = key_file.string(), .progress = {}});
    CHECK_TRUE_TEXT(session.has_value(), session.has_value() ? "" : session.error().message.c_str());
    return *session;
  }
  std::optional<WrittenRun> begin(std::int64_t host_id, int second) {
    return std::optional<WrittenRun>(std::in_place, folder, key, host_id, second);
  }
};

TEST(ReadSession, GivesEveryShotWithItsReadout) {
  auto run = begin(5, 0);
  for (int id : {1, 2, 3}) run->shot(id);
  run->result(2, "2026-01-31T09:30:07.250Z");
  run.reset();
  const StoredSession session = read();
  CHECK_TRUE_TEXT(session.verified, all_remarks(session).c_str());
  LONGS_EQUAL(0, session.remarks.size());
  LONGS_EQUAL(3, session.shots.size());
  for (int i = 0; i < 3; ++i) {
    const Shot& shot = session.shots[static_cast<std::size_t>(i)];
    CHECK_EQUAL(std::to_string(i + 1), shot.name);
    LONGS_EQUAL(1, shot.digitizations.size());
    CHECK_FALSE(shot.digitizations[0].by_hand);
    CHECK_FALSE(shot.rejected.has_value());
    // As the synthetic shot's bounce has it; 0.2 mm of noise on a leg of some ten images in 30 ms leave 0.02 m/s.
    DOUBLES_EQUAL(15.62, shot.readout.value[Quantity::vx_td_mps].value(), 0.1);
  }
  CHECK_EQUAL("2026-01-31T09:30:07.250Z", session.shots[1].utc);
  CHECK_EQUAL("2026-01-31T09:30:00.009Z", session.shots[0].utc);  // its frame is the log's ninth record
  LONGS_EQUAL(1, session.runs.size());
  LONGS_EQUAL(5, session.runs[0].host_id);
}

TEST(ReadSession, JoinsTheRunsOfAFolder) {
  auto run = begin(5, 0);
  run->shot(1);
  const auto sequence = run->sequence;
  const auto mono_ns = run->mono_ns;
  run = begin(6, 60);
  run->sequence = sequence;
  run->mono_ns = mono_ns + 60'000'000'000;
  run->shot(2);
  run.reset();
  testing::write_text(
      folder / "runs.jsonl",
      "{\"utc\":\"2026-01-31T09:30:00.000Z\",\"host_id\":\"5\",\"operator\":\"ann@lab\",\"shots\":1,"
      "\"until\":true,\"notes\":{\"spin\":\"zero\"},\"command\":[\"strobe\",\"fire\"]}\n{\"utc\":\"2026");
  const StoredSession session = read();
  LONGS_EQUAL(2, session.logs.size());
  LONGS_EQUAL(2, session.runs.size());  // the second's record was cut short: its log tells of it
  CHECK_EQUAL("ann@lab", session.runs[0].operator_name);
  CHECK_TRUE(session.runs[0].until);
  CHECK_EQUAL("zero", session.runs[0].notes.at("spin"));
  LONGS_EQUAL(6, session.runs[1].host_id);
  CHECK_TRUE(told(session, "runs.jsonl:2: "));
  LONGS_EQUAL(2, session.shots.size());
  LONGS_EQUAL(5, session.shots[0].host_id);
  LONGS_EQUAL(6, session.shots[1].host_id);
}

TEST(ReadSession, FollowsAShotFromOneLogIntoTheNext) {
  auto run = begin(5, 0);
  run->heartbeat();
  run->arm_and_fire();
  run->started(1);
  run->flash(1);
  const auto sequence = run->sequence;
  const auto mono_ns = run->mono_ns;
  run = begin(6, 2);
  run->sequence = sequence;
  run->mono_ns = mono_ns + 2'000'000'000;
  run->heartbeat();
  // The first host was killed; its shot's end and photograph are heard by the next one.
  run->ended(1);
  auto made = make_shot({});
  made.shot.first_sequence = 2;
  made.shot.last_sequence = run->sequence;
  run->log(messages::Channel::shot, made.shot);
  run->frame(1);
  run->shot(2);
  run.reset();
  const StoredSession session = read();
  LONGS_EQUAL(2, session.shots.size());
  LONGS_EQUAL(5, session.shots[0].host_id);
  CHECK_FALSE(session.shots[0].rejected.has_value());
  CHECK_FALSE(session.shots[0].readout.flags.has(Flag::events_missing));
  LONGS_EQUAL(1, session.shots[0].digitizations.size());
}

TEST(ReadSession, TellsTwoBootsApart) {
  auto run = begin(5, 0);
  run->shot(1);
  run->wait_s(6);
  const std::int64_t other = 0x1f2e4d00'00000099;
  run->sequence = 0;
  run->heartbeat(other);
  run->arm_and_fire(other);
  run->started(1, other);
  run->ended(1, other);
  run->summary(1, other);
  run->frame(1, other);
  run.reset();
  const StoredSession session = read();
  LONGS_EQUAL(2, session.shots.size());
  CHECK_EQUAL("1", session.shots[0].name);
  CHECK_EQUAL("1/1f2e4d", session.shots[1].name);
  CHECK_EQUAL(other, (*host::find_shot(session, "1/1f2e4d"))->boot_id);
  const auto none = host::find_shot(session, "2");
  CHECK_FALSE(none.has_value());
  STRCMP_CONTAINS("there are: 1, 1/1f2e4d", none.error().message.c_str());
}

TEST(ReadSession, LeavesOtherHostsShotsOutAndCountsThem) {
  auto run = begin(5, 0);
  run->shot(1);
  run->wait_s(1);
  run->started(2, WrittenRun::kBoot, 9);
  run->ended(2);
  run->summary(2, WrittenRun::kBoot, 9);
  run->started(3, WrittenRun::kBoot, 5, true);
  run.reset();
  const StoredSession session = read();
  LONGS_EQUAL(1, session.shots.size());
  CHECK_TRUE_TEXT(told(session, "1 shot of other hosts is left out"), all_remarks(session).c_str());
}

TEST(ReadSession, HasTheShotsThatNobodySawTheEndOf) {
  auto run = begin(5, 0);
  run->shot(1);
  run->arm_and_fire();
  run->started(2);
  run->ended(2);
  run->summary(2);  // and no photograph
  run->arm_and_fire();
  run->started(3);  // host and firmware are killed
  run.reset();
  const StoredSession session = read();
  LONGS_EQUAL(3, session.shots.size());
  CHECK_TRUE(session.shots[1].readout.flags.has(Flag::no_photograph));
  CHECK_TRUE(session.shots[1].rejected.has_value());
  CHECK_TRUE(session.shots[1].digitizations.empty());
  CHECK_FALSE(session.shots[2].summary.has_value());
  CHECK_TRUE(session.shots[2].readout.flags.has(Flag::shot_aborted));
  LONGS_EQUAL(5, session.shots[2].host_id);
  CHECK_TRUE_TEXT(told(session, "the end of shot 3 is in no log"), all_remarks(session).c_str());
}

TEST(ReadSession, HasTheReadoutThatALaterRunToldOfAShot) {
  auto run = begin(5, 0);
  run->mono_ns = 5'000'600'000'000;  // the shutter of a synthetic shot has closed by then
  run->heartbeat();
  run->arm_and_fire();
  run->started(1);
  run->ended(1);
  run->summary(1);  // and is killed
  const auto sequence = run->sequence;
  const auto mono_ns = run->mono_ns;
  run = begin(6, 60);
  run->sequence = sequence;
  run->mono_ns = mono_ns + 60'000'000'000;
  run->wait_s(20);  // no log tells for how long the next run waits
  run->frame(1, WrittenRun::kBoot, "photographs/shot-0001-a.tif");
  strobe_msgs::readout_t readout{};
  readout.host_id = 6;
  readout.boot_id = WrittenRun::kBoot;
  readout.shot_id = 1;
  run->log(messages::Channel::readout, readout);
  // One that came too late for its own run: that has told so before.
  run->arm_and_fire();
  run->started(2);
  run->ended(2);
  run->summary(2);
  run->wait_s(20);
  readout.shot_id = 2;
  run->log(messages::Channel::readout, readout);
  run->frame(2);
  run.reset();
  const StoredSession session = read();
  LONGS_EQUAL(2, session.shots.size());
  CHECK_FALSE_TEXT(session.shots[0].rejected.has_value(), all_remarks(session).c_str());
  LONGS_EQUAL(1, session.shots[0].digitizations.size());
  CHECK_TRUE(session.shots[1].readout.flags.has(Flag::no_photograph));
}

TEST(ReadSession, TakesFromAJournalWhatTheLogsLack) {
  auto run = begin(5, 0);
  run->heartbeat();
  run->arm_and_fire();
  run->started(1);
  run->frame(1, WrittenRun::kBoot);
  const auto sequence = run->sequence;
  run.reset();
  // The journal is the same in raw messages; it goes on after the host's end.
  WrittenRun journal(place / "rig", key, 5, 0);
  journal.sequence = sequence - 2;
  const auto raw = [&journal](const auto& message, messages::Channel channel) {
    journal.log_bytes(messages::channel_name("bench", channel), messages::encode(message));
  };
  strobe_msgs::event_t event{};
  event.schema_version = strobe_msgs::event_t::SCHEMA_VERSION;
  event.boot_id = WrittenRun::kBoot;
  event.shot_id = 1;
  event.flash_index = -1;
  for (std::int64_t each = sequence; each <= sequence + 1; ++each) {
    event.sequence = each;
    event.kind = each == sequence ? strobe_msgs::event_t::SHOT_STARTED : strobe_msgs::event_t::SHOT_ENDED;
    raw(event, messages::Channel::event);
  }
  auto made = make_shot({});
  made.shot.first_sequence = sequence;
  made.shot.last_sequence = sequence + 1;
  raw(made.shot, messages::Channel::shot);
  fs::copy_file(log_at(place / "rig", 0), folder / "journal-4d.lcmlog");
  const StoredSession session = read();
  LONGS_EQUAL(1, session.shots.size());
  CHECK_FALSE_TEXT(session.shots[0].rejected.has_value(), all_remarks(session).c_str());
  CHECK_FALSE(session.verified);
  CHECK_TRUE(told(session, "strobed's journal"));
}

TEST(ReadSession, ReadsALogUpToWhereItIsDamaged) {
  auto run = begin(5, 0);
  run->shot(1);
  run->shot(2);
  run.reset();
  const fs::path log = log_at(folder, 0);
  fs::resize_file(log, fs::file_size(log) - 100);
  StoredSession session = read();
  LONGS_EQUAL(2, session.shots.size());
  CHECK_TRUE(session.shots[1].digitizations.empty());  // its frame was the last record
  CHECK_TRUE_TEXT(told(session, "bytes cannot be read as messages"), all_remarks(session).c_str());
  std::ofstream(log, std::ios::app | std::ios::binary) << std::string(5000, '\x5a') << "junk";
  session = read();
  LONGS_EQUAL(2, session.shots.size());
  CHECK_TRUE(told(session, "bytes cannot be read as messages"));
}

TEST(ReadSession, AsksForNoDigitizingOfAnAbortedShot) {
  auto run = begin(5, 0);
  for (const int shot : {1, 2}) {
    run->arm_and_fire();
    run->started(shot);
    run->ended(shot);
    run->summary(shot, WrittenRun::kBoot, 0, 1, shot == 1 ? "a late flash" : "");
  }
  run.reset();
  fs::create_directory(folder / "photographs");
  for (const char* name : {"shot-0001-a.tif", "shot-0002-b.tif"})
    testing::write_text(folder / "photographs" / name, "x");
  const StoredSession session = read();
  CHECK_TRUE_TEXT(told(session, "the photograph of shot 2 was never digitized"),
                  all_remarks(session).c_str());
}

TEST(ReadSession, FindsPhotographsByTheFrameOrByTheirNames) {
  auto run = begin(5, 0);
  run->shot(1, "photographs/shot-0001-a.tif");
  run->arm_and_fire();
  run->started(2);
  run->ended(2);
  run->summary(2);
  run.reset();
  fs::create_directory(folder / "photographs");
  for (const char* name : {"shot-0001-a.tif", "shot-0002-b.tif"})
    testing::write_text(folder / "photographs" / name, "x");
  StoredSession session = read();
  CHECK_EQUAL((folder / "photographs/shot-0001-a.tif").string(),
              session.shots[0].photograph.value().string());
  CHECK_EQUAL((folder / "photographs/shot-0002-b.tif").string(),
              session.shots[1].photograph.value().string());
  CHECK_TRUE_TEXT(told(session, "the photograph of shot 2 was never digitized"),
                  all_remarks(session).c_str());
  testing::write_text(folder / "photographs/shot-0002-c.tif", "x");
  session = read();
  CHECK_FALSE(session.shots[1].photograph.has_value());
  CHECK_TRUE(told(session, "may show shot 2"));
}

TEST(ReadSession, TheNewestDigitizationCounts) {
  auto run = begin(5, 0);
  run->shot(1, "photographs/shot-0001-a.tif");
  run.reset();
  fs::create_directory(folder / "digitizations");
  int number = 0;
  for (const double vx : {14.0, 13.0}) {
    Scenario other;
    other.bounce.vx_td = vx;
    const auto frame = messages::frame_from_lcm(make_shot(other).frame);
    std::string text = messages::frame_to_json(*frame);
    text.back() = ',';
    testing::write_text(folder / ("digitizations/shot-0001-4d-" + std::to_string(++number) + ".json"),
                        text + "\"utc\":\"2026-02-01T00:00:00.000Z\",\"who\":\"ann@lab\"}\n");
  }
  testing::write_text(folder / "digitizations/shot-0001-4d-1.toml", "");
  testing::write_text(folder / "digitizations/shot-0001-4d-3.json.undone", "{}");
  StoredSession session = read();
  LONGS_EQUAL_TEXT(3, session.shots[0].digitizations.size(), all_remarks(session).c_str());
  DOUBLES_EQUAL(13.0, session.shots[0].readout.value[Quantity::vx_td_mps].value(), 0.1);
  const auto& first = session.shots[0].digitizations[1];
  CHECK_EQUAL("ann@lab", first.who);
  CHECK_TRUE(first.by_hand);
  CHECK_FALSE(first.corrections.empty());
  CHECK_TRUE(session.shots[0].digitizations[2].corrections.empty());
  // One that cannot be read is told, and those before it count.
  testing::write_text(folder / "digitizations/shot-0001-4d-2.json", "{\"shot_id\":1,");
  session = read();
  DOUBLES_EQUAL(14.0, session.shots[0].readout.value[Quantity::vx_td_mps].value(), 0.1);
  CHECK_TRUE_TEXT(told(session, "shot-0001-4d-2.json: "), all_remarks(session).c_str());
}

TEST(ReadSession, WithoutTheKeyIsUnverified) {
  auto run = begin(5, 0);
  run->shot(1);
  run.reset();
  const fs::path other = place / "other.key";
  CHECK_TRUE(authentication::make_key_file(other).has_value());
  const auto session =
      host::read_session(folder, {.rig_path = "", .key_file = other.string(), .progress = {}});
  CHECK_TRUE(session.has_value());
  CHECK_FALSE(session->verified);
  LONGS_EQUAL(1, session->shots.size());
  CHECK_FALSE(session->shots[0].verified);
  CHECK_TRUE(told(*session, "unverified: host-20260131T093000Z.lcmlog has no seal"));
}

TEST(ReadSession, NamesWhatIsNotThere) {
  STRCMP_CONTAINS("no such folder", host::read_session(folder).error().message.c_str());
  fs::create_directory(folder);
  STRCMP_CONTAINS("no log of a host", host::read_session(folder).error().message.c_str());
  testing::write_text(folder / "host-20260131T093000Z.lcmlog", "");
  STRCMP_CONTAINS("rig.toml", host::read_session(folder).error().message.c_str());
}

TEST(ReadSession, TellsHowFarItIs) {
  auto run = begin(5, 0);
  run->shot(1);
  run->wait_s(1200);
  run.reset();
  std::vector<double> shares;
  CHECK_TRUE(host::read_session(folder, {.rig_path = "",
                                         .key_file = key_file.string(),
                                         .progress = [&](double share) { shares.push_back(share); }})
                 .has_value());
  CHECK_TRUE(shares.size() >= 2);
  CHECK_TRUE(std::ranges::is_sorted(shares));
  DOUBLES_EQUAL(1.0, shares.back(), 0.0);
}
