// Who may run it, and where it may be installed.
#include <csignal>
#include <string>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/line_watcher.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;

namespace {

/// A busy machine makes flashes late: here that is no reason to abort a shot.
RigFixtureOptions patient() {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  options.rig_edits.emplace_back("abort_late_us = 1500", "abort_late_us = 300000");
  return options;
}

}  // namespace

TEST_GROUP(Session){};

TEST(Session, AnOrdinaryUserFiresWithAWarning) {
  RigFixtureOptions options;
  options.rights = strobe::testing::Privileges::ordinary;
  options.rig_edits = kShortExposure;
  RigFixture bench(options);
  expect_ready(bench);
  CHECK_TEXT(bench.log().find("warn") != std::string::npos, bench.log().c_str());
  strobe::testing::Command fire = bench.fire(1, 0);
  fire.rights = strobe::testing::Privileges::ordinary;
  const auto fired = strobe::testing::run_process(fire, kLongestWait);
  CHECK(!readouts(fired.out).empty());
  if (fired.status == ExitStatus({0, 0})) return;
  // Without its rights a busy machine makes shots late: then each must say so.
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  for (const auto& readout : readouts(fired.out)) CHECK_TEXT(!readout.at("flags").empty(), fired.err.c_str());
}

TEST(Session, WithoutRealTimeRightsStrobedRefusesUnlessToldOtherwise) {
  RigFixtureOptions options;
  options.rights = strobe::testing::Privileges::ordinary;
  options.shell = "\"$1\" --config \"$3\" --session \"$5\" --lcm-url \"$7\"";
  RigFixture bench(options);
  CHECK_EQUAL(ExitStatus({2, 0}), bench.sim().wait(20s));
  CHECK_TEXT(bench.log().find("--allow-no-rt") != std::string::npos, bench.log().c_str());
}

TEST(Session, FolderHoldsAllThatIsNeededToRecomputeIt) {
  RigFixture bench;
  expect_ready(bench);
  const auto fired =
      strobe::testing::run_process(bench.fire(2, 0, {"--note", "remarks=two shots"}), kLongestWait);
  CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
  bench.finish();
  CHECK(std::filesystem::exists(bench.session() / "rig.toml"));
  // Points of the simulated tablet are too coarse for a code.
  CHECK_TEXT(fired.err.find("even train: ") != std::string::npos, fired.err.c_str());
  const std::string plan = strobe::testing::read_text(bench.session() / "plan.toml");
  CHECK_TEXT(plan.find("period_us = 3000\n") != std::string::npos, plan.c_str());
  CHECK_TEXT(plan.find("spacing") == std::string::npos, plan.c_str());
  const auto table = strobe::testing::read_csv(bench.session() / "results.csv");
  LONGS_EQUAL(readouts(fired.out).size(), table.rows.size());
  const auto flashes = strobe::testing::read_csv(bench.session() / "flashes.csv");
  const LogContents journal = read_log(bench.journal());
  std::size_t planned = 0;
  for (const auto& shot : journal.shots) planned += shot.flashes.size();
  LONGS_EQUAL(planned, flashes.rows.size());
  CHECK_EQUAL(std::to_string(journal.shots.front().flashes.front().commanded_ns),
              flashes.rows.front().at(flashes.column("commanded_ns")));
  CHECK_EQUAL("two shots", readouts(fired.out).front().at("record").at("remarks").get<std::string>());
}

TEST(Session, TheFirstCtrlCFinishesTheShotUnderWayAndTheSessionCanBeGoneOnWith) {
  RigFixture bench(patient());
  expect_ready(bench);
  const std::string host = bench.folder() / "host";
  strobe::testing::Command fire = bench.strobe(
      {"fire", "--shots", "3", "--retries", "0", "--session", host, "--plain", "--spin", "zero"});
  LineWatcher watch(bench.chip_dir());
  auto first = bench.start(fire);
  CHECK(watch.wait_for("SHUTTER", 1, kLongestWait) != 0);
  first.signal(SIGINT);
  CHECK_EQUAL(ExitStatus({1, 0}), first.wait(kLongestWait));
  const std::string said = first.err();
  CHECK_TEXT(said.find("finishing shot 1; press Ctrl-C again to stop at once") != std::string::npos,
             said.c_str());
  CHECK_TEXT(said.find("go on with: strobe fire --resume --session " + host) != std::string::npos,
             said.c_str());
  LONGS_EQUAL(1, strobe::testing::read_csv(host + "/results.csv").rows.size());
  const std::string text = strobe::testing::read_text(host + "/shots.txt");
  CHECK_TEXT(text.find("Z  shot 1") != std::string::npos, text.c_str());
  CHECK_TEXT(text.find("finishing shot 1") != std::string::npos, text.c_str());

  strobe::testing::Command on = bench.strobe({"fire", "--resume", "--session", host, "--plain"});
  const auto resumed = strobe::testing::run_process(on, kLongestWait);
  CHECK_TEXT(resumed.status == ExitStatus({0, 0}), resumed.err.c_str());
  CHECK_TEXT(resumed.err.find("3 of 3 shots counted") != std::string::npos, resumed.err.c_str());
  const auto table = strobe::testing::read_csv(host + "/results.csv");
  int counted = 0;
  for (const auto& row : table.rows) {
    counted += row.at(table.column("rejected")).empty() ? 1 : 0;
    CHECK_EQUAL("zero", row.at(table.column("spin")));
  }
  LONGS_EQUAL(3, counted);
  const auto again = strobe::testing::run_process(on, kLongestWait);
  CHECK_TEXT(again.status == ExitStatus({0, 0}), again.err.c_str());
  CHECK_TEXT(again.err.find("holds 3 shots that count, of 3 wanted: nothing is fired") != std::string::npos,
             again.err.c_str());
}

TEST(Session, CtrlBackslashStopsTheShotUnderWayAtOnce) {
  RigFixture bench(patient());
  expect_ready(bench);
  LineWatcher watch(bench.chip_dir());
  auto fire = bench.start(bench.fire(3, 0));
  CHECK(watch.wait_for("SHUTTER", 1, kLongestWait) != 0);
  fire.signal(SIGQUIT);
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
  CHECK_TEXT(fire.err().find("stopping at once") != std::string::npos, fire.err().c_str());
  bench.finish();
  LONGS_EQUAL(1, read_log(bench.journal()).shots.size());
}

TEST(Session, TheWorkstationHearsThatOutputsMayBeActive) {
  RigFixture bench;
  expect_ready(bench);
  auto live = bench.start(bench.strobe({"live", "--plain"}));
  CHECK_TEXT(live.wait_for_err("listening", kLongestWait), live.err().c_str());
  RawHost host(bench);
  CHECK(host.wait_status());
  LineWatcher watch(bench.chip_dir());
  CHECK(host.fire_until_flash(watch,
                              [&host](std::int64_t token) { return host.fire_command(token, true); }) != 0);
  watch.unplug();
  CHECK_TEXT(live.wait_for_err("THE OUTPUTS MAY BE ACTIVE: press the e-stop", kLongestWait),
             (live.err() + bench.log()).c_str());
  live.signal(SIGINT);
  CHECK(live.wait(kLongestWait).has_value());
}

TEST(Session, ShotNumbersGoOnInTheSameFolder) {
  RigFixture bench;
  expect_ready(bench);
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(2, journal.shots.size());
  LONGS_EQUAL(1, journal.shots[0].shot_id);
  LONGS_EQUAL(2, journal.shots[1].shot_id);
}

TEST(Session, UsesNoShotsNumberTwiceAfterADeath) {
  RigFixtureOptions options;
  options.shell = "\"$@\"; rm \"$5\"/journal-*; \"$@\"";  // nothing of the journal had come to the disk
  RigFixture bench(options);
  expect_ready(bench);
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  const std::filesystem::path old_journal = bench.journal();
  const pid_t guardian = bench.guardian();
  kill(bench.worker(), SIGKILL);
  CHECK(strobe::testing::wait_until([&] { return bench.guardian() != guardian && bench.worker() != 0; },
                                    kLongestWait));
  CHECK(strobe::testing::wait_until([&] { return bench.journal() != old_journal; }, kLongestWait));
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(1, journal.shots.size());
  CHECK(journal.shots[0].shot_id > 1);
  kill(bench.guardian(), SIGTERM);
}

TEST(Session, StartsAgainBesideTheOldJournalAndGoesOnCounting) {
  RigFixtureOptions options;
  options.shell = "\"$@\"; \"$@\"";  // strobed again once it was ended
  RigFixture bench(options);
  expect_ready(bench);
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  const std::filesystem::path old_journal = bench.journal();
  const pid_t guardian = bench.guardian();
  kill(guardian, SIGTERM);
  CHECK(
      strobe::testing::wait_until([&] { return bench.guardian() != guardian && bench.worker() != 0; }, 10s));
  CHECK(strobe::testing::wait_until([&] { return bench.journal() != old_journal; }, kLongestWait));
  strobe::testing::run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(1, journal.shots.size());
  LONGS_EQUAL(2, journal.shots[0].shot_id);
  kill(bench.guardian(), SIGTERM);
}
