// results.csv made anew from a session.
#include <filesystem>
#include <string>
#include <vector>

#include "common/authentication/key_file.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/shot_outcome.hpp"
#include "host/session/shot_table.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/string_from.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace strobe;
using host::Shot;
using testing::read_text;
using testing::write_text;

constexpr const char* kUtc = "2026-01-31T09:30:00.000Z";

Shot shot(int id) {
  Shot stored;
  stored.name = std::to_string(id);
  stored.utc = kUtc;
  stored.boot_id = 0x4d;
  stored.shot_id = id;
  stored.readout.value[reduction::Quantity::e] = 0.1 * id;
  stored.readout.method = "best";
  stored.digitizations.emplace_back().frame.source = "auto";
  return stored;
}

/// As fire writes it, one after the other.
std::string written(const std::filesystem::path& file, const std::vector<Shot>& shots) {
  for (const Shot& each : shots)
    CHECK_TRUE(host::ResultsCsv::open(file)->add(each).has_value());
  return read_text(file);
}

std::string row(const Shot& shot) {
  return host::results_line(shot) + "\n";
}

}  // namespace

TEST_GROUP(ResultsMadeAnew) {
  testing::TemporaryFolder folder;
  host::StoredSession session;

  void setup() override {
    session.folder = folder.path();
    for (const int id : {1, 2, 3}) session.shots.push_back(shot(id));
  }
};

TEST(ResultsMadeAnew, AreTheBytesThatFireWrote) {
  const std::string before = written(folder / "results.csv", session.shots);
  CHECK_EQUAL(before, host::results_table(session, host::parse_results(before)));
  CHECK_TRUE(host::rebuild_results(session, folder / "results.csv").has_value());
  CHECK_EQUAL(before, read_text(folder / "results.csv"));
  CHECK_EQUAL(before, host::results_table(session, {}));
  STRCMP_CONTAINS("\"digitization\"", read_text(folder / "results.csv-metadata.json").c_str());
}

TEST(ResultsMadeAnew, HaveTheRowsThatWereMissingEachOnce) {
  const std::string header = host::results_header() + "\n";
  const std::string all = header + row(session.shots[0]) + row(session.shots[1]) + row(session.shots[2]);
  for (const std::string& lost :
       {header + row(session.shots[2]), header + row(session.shots[0]) + row(session.shots[0]),
        header + row(session.shots[1]) + "2026-01-31T09", header.substr(0, 20), std::string()})
    CHECK_EQUAL(all, host::results_table(session, host::parse_results(lost)));
}

TEST(ResultsMadeAnew, KeepTheOrderInWhichTheResultsCame) {
  const std::string header = host::results_header() + "\n";
  const std::string before = header + row(session.shots[2]) + row(session.shots[0]);
  CHECK_EQUAL(header + row(session.shots[2]) + row(session.shots[0]) + row(session.shots[1]),
              host::results_table(session, host::parse_results(before)));
}

TEST(ResultsMadeAnew, KeepRowsThatTheSessionDoesNotTellOf) {
  const Shot other = shot(9);
  // A version's that had neither the last two of these columns nor the third dimension.
  const std::string spatial(3 * reduction::kSpatialCount, ',');
  std::string shorter = row(other);
  shorter.erase(shorter.size() - (",auto,9" + spatial + "\n").size());
  const std::string table = host::results_table(
      session, host::parse_results(host::earlier_results_headers().at(1) + "\n" + shorter + "\n"));
  STRCMP_CONTAINS((shorter + ",," + spatial + "\n").c_str(), table.c_str());
  STRCMP_CONTAINS(row(session.shots[0]).c_str(), table.c_str());
}

TEST(ResultsMadeAnew, SayWhoMeasured) {
  Shot& corrected = session.shots[1];
  corrected.digitizations.push_back({*corrected.frame(), true, kUtc, "ann@lab", "digitizations/x.json", {}});
  session.shots[2].digitizations.clear();
  const std::string table = host::results_table(session, {});
  const std::string spatial(3 * reduction::kSpatialCount, ',');
  for (const char* words : {",auto,1", ",corrected,2", ",,3"})
    STRCMP_CONTAINS((words + spatial + "\n").c_str(), table.c_str());
}

// Corrections of a stored shot: what can be taken back, and what cannot be corrected.
namespace {

using namespace strobe;
using namespace strobe::host_test;
using host::StoredSession;
using reduction::Quantity;
namespace fs = std::filesystem;

}  // namespace

TEST_GROUP(CorrectionsOfAShot) {
  testing::TemporaryFolder place;
  fs::path folder = place / "session";
  fs::path key_file = place / "lab.key";
  authentication::Key key = authentication::make_key_file(key_file).value().key;

  void setup() override {
    WrittenRun run(folder, key, 5, 0);
    run.shot(1);
    run.arm_and_fire();
    run.started(2);
  }
  StoredSession read() {
    return host::read_session(folder, {.rig_path = "", .key_file = key_file.string(), .progress = {}})
        .value();
  }
  /// As if the ball had come at that speed.
  void correct(int number, double vx_mps) {
    fs::create_directories(folder / "digitizations");
    Scenario other;
    other.bounce.vx_td = vx_mps;
    std::string text = messages::frame_to_json(*messages::frame_from_lcm(make_shot(other).frame));
    text.back() = ',';
    const fs::path stem = host::digitization_stem(folder, {WrittenRun::kBoot, 1}, number);
    testing::write_text(stem.string() + ".json", text + "\"utc\":\"\",\"who\":\"ann@lab\"}\n");
    testing::write_text(stem.string() + ".toml", corrections(number));
  }
  static std::string corrections(int number) {
    return "[[remove]]\nat_px = [1, " + std::to_string(number) + "]\n";
  }
  static double vx(const host::Shot& shot) {
    return shot.readout.value[Quantity::vx_td_mps].value();
  }
};

TEST(CorrectionsOfAShot, AreTakenBackOneByOneAndKept) {
  correct(1, 14.0);
  correct(2, 13.0);
  for (const double expected : {14.0, 15.62}) {
    const StoredSession session = read();
    const auto changed = host::take_back(session, session.shots[0]);
    CHECK_TRUE(changed.has_value());
    DOUBLES_EQUAL(expected, vx(changed->shot), 0.1);
    DOUBLES_EQUAL(vx(changed->shot), vx(read().shots[0]), 0.0);
  }
  for (const char* name : {"1.json", "1.toml", "2.json", "2.toml"})
    CHECK_TRUE_TEXT(fs::exists(folder / "digitizations" / (std::string("shot-0001-4d-") + name + ".undone")),
                    name);
  const StoredSession session = read();
  const auto none = host::take_back(session, session.shots[0]);
  CHECK_FALSE(none.has_value());
  STRCMP_CONTAINS("shot 1 has no correction to be taken back", none.error().message.c_str());
}

TEST(CorrectionsOfAShot, GivenTwiceAreTheSame) {
  correct(1, 14.0);
  const StoredSession session = read();
  const auto again =
      host::put_correction(session, session.shots[0], corrections(1), "c.toml", {"ann@lab", ""});
  CHECK_TRUE(again.has_value());
  CHECK_FALSE(again->changed);
}

TEST(CorrectionsOfAShot, NeedAPhotographAndAnEnd) {
  const StoredSession session = read();
  const char* text = "[[remove]]\nat_px = [1, 1]\n";
  STRCMP_CONTAINS(
      "shot 1 has no photograph in the session",
      host::put_correction(session, session.shots[0], text, "c.toml", {"", ""}).error().message.c_str());
  STRCMP_CONTAINS(
      "c.toml:1: ",
      host::put_correction(session, session.shots[0], "[[add", "c.toml", {"", ""}).error().message.c_str());
  CHECK_FALSE(fs::exists(folder / "digitizations"));
  host::Shot endless = session.shots[1];
  endless.photograph = folder / "photographs/shot-0002-a.tif";
  STRCMP_CONTAINS("strobed ended during the shot", host::redigitize(session, endless).error().message.c_str());
}

TEST(CorrectionsOfAShot, APhotographThatCannotBeReadIsToldAndStopsNothing) {
  {
    WrittenRun run(folder, key, 5, 60);
    run.mono_ns += 60'000'000'000;
    run.sequence = 100;
    run.arm_and_fire();
    run.started(3);
    run.ended(3);
    run.summary(3);
  }
  fs::create_directories(folder / "photographs");
  testing::write_text(folder / "photographs/shot-0003-a.tif", "no photograph");
  StoredSession session = read();
  const std::size_t remarks = session.remarks.size();
  const host::Completion done = host::complete(session);
  LONGS_EQUAL(0, done.digitized);
  LONGS_EQUAL(1, done.problems.size());
  STRCMP_CONTAINS("shot 3: ", done.problems.front().c_str());
  LONGS_EQUAL(remarks - 1, session.remarks.size());
}

TEST(CorrectionsOfAShot, AreReadWithoutTimesSinceTheFlashesHaveThem) {
  correct(1, 14.0);
  const fs::path file = host::digitization_stem(folder, {WrittenRun::kBoot, 1}, 1).string() + ".json";
  const double timed = vx(read().shots[0]);
  std::string text = testing::read_text(file);
  for (std::size_t at = 0; (at = text.find("\"time_s\":", at)) != std::string::npos;) {
    at += std::string_view("\"time_s\":").size();
    text.replace(at, text.find(',', at) - at, "null");
  }
  testing::write_text(file, text);
  STRCMP_CONTAINS("\"time_s\":null", text.c_str());
  DOUBLES_EQUAL(timed, vx(read().shots[0]), 0.0);
}
