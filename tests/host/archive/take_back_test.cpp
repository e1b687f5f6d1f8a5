// Corrections of a stored shot: what can be taken back, and what cannot be corrected.
#include <filesystem>

#include "common/authentication/key_file.hpp"
#include "common/messages/json_conversions.hpp"
#include "common/messages/lcm_conversions.hpp"
#include "host/archive/redigitize.hpp"
#include "host/archive/stored_digitizations.hpp"
#include "tests/host/archive/written_session.hpp"
#include "tests/support/temporary_folder.hpp"

#include "tests/support/string_from.hpp"

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
  static double vx(const host::StoredShot& shot) {
    return shot.result.readout.value[Quantity::vx_td_mps].value();
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
  host::StoredShot endless = session.shots[1];
  endless.photograph = folder / "photographs/shot-0002-a.tif";
  STRCMP_CONTAINS("the firmware ended in it", host::redigitize(session, endless).error().message.c_str());
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
