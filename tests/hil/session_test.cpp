// Who may run it, and where it may be installed.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <string>

#include "common/wire/log_reader.hpp"
#include "tests/hil/line_changes.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// A busy machine makes flashes late: here that is no reason to abort a shot.
RigFixtureOptions patient() {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  options.rig_edits.emplace_back("abort_late_us = 1500", "abort_late_us = 300000");
  return options;
}

int files_ending(const fs::path& folder, const std::string& ending) {
  int count = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().string().ends_with(ending)) ++count;
  return count;
}

/// What of a readout does not depend on who kept its messages.
std::string without_verified(const std::string& lines) {
  std::string text;
  for (json readout : readouts(lines)) {
    readout.erase("verified");
    text += readout.dump() + "\n";
  }
  return text;
}

/// As a host leaves its log that is killed before it has published the first photograph's measurement.
void cut_before_the_first_frame(const fs::path& log) {
  strobe::wire::LogReader reader(log);
  strobe::wire::LogRecord record;
  while (reader.next(record)) {
    if (!record.channel.ends_with("/FRAME")) continue;
    fs::resize_file(log, static_cast<std::uintmax_t>(record.offset));
    return;
  }
}

}  // namespace

TEST_GROUP(Session){};

TEST(Session, AnOrdinaryUserFiresWithAWarning) {
  RigFixtureOptions options;
  options.rights = Privileges::ordinary;
  options.rig_edits = kShortExposure;
  ReadyRig bench(options);
  STRCMP_CONTAINS("warn", bench.log().c_str());
  Command fire = bench.fire(1, 0);
  fire.rights = Privileges::ordinary;
  const auto fired = run_process(fire, kLongestWait);
  CHECK(!readouts(fired.out).empty());
  if (fired.status == ExitStatus({0, 0})) return;
  // Without its rights a busy machine makes shots late: then each must say so.
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  for (const auto& readout : readouts(fired.out)) CHECK_TEXT(!readout.at("flags").empty(), fired.err.c_str());
}

TEST(Session, WithoutRealTimeRightsStrobedRefusesUnlessToldOtherwise) {
  RigFixtureOptions options;
  options.rights = Privileges::ordinary;
  options.shell = "\"$1\" --config \"$3\" --session \"$5\" --lcm-url \"$7\"";
  RigFixture bench(options);
  CHECK_EQUAL(ExitStatus({2, 0}), bench.sim().wait(20s));
  STRCMP_CONTAINS("--allow-no-rt", bench.log().c_str());
}

TEST(Session, FolderHoldsAllThatIsNeededToRecomputeIt) {
  ReadyRig bench;
  const auto fired = ran(bench.fire(2, 0, {"--note", "remarks=two shots"}));
  bench.finish();
  CHECK(std::filesystem::exists(bench.session() / "rig.toml"));
  // Points of the simulated tablet are too coarse for a code.
  STRCMP_CONTAINS("even train: ", fired.err.c_str());
  const std::string plan = read_text(bench.session() / "plan.toml");
  STRCMP_CONTAINS("period_us = 3000\n", plan.c_str());
  CHECK_TEXT(plan.find("spacing") == std::string::npos, plan.c_str());
  const auto table = read_csv(bench.session() / "results.csv");
  LONGS_EQUAL(readouts(fired.out).size(), table.rows.size());
  const auto flashes = read_csv(bench.session() / "flashes.csv");
  const LogContents journal = read_log(bench.journal());
  std::size_t planned = 0;
  for (const auto& shot : journal.shots) planned += shot.flashes.size();
  LONGS_EQUAL(planned, flashes.rows.size());
  CHECK_EQUAL(std::to_string(journal.shots.front().flashes.front().commanded_ns),
              flashes.rows.front().at(flashes.column("commanded_ns")));
  CHECK_EQUAL("two shots", readouts(fired.out).front().at("record").at("remarks").get<std::string>());
}

// Of zero_23 e scatters by about 0.02: five shots or a few more.
TEST(Session, UntilKnownFiresUntilTheMeanIsKnownAndEveryoneIsToldSo) {
  ReadyRig bench(patient());
  const std::string host = bench.folder() / "host";
  const auto fired = ran(bench.strobe(
      {"fire", "--until-known", "e:0.03", "--retries", "30", "--session", host, "--plain"}));
  STRCMP_CONTAINS("of 0.03 wanted; about ", fired.err.c_str());
  STRCMP_CONTAINS("shots counted, enough to know e ± 0.0", fired.err.c_str());
  const auto table = read_csv(host + "/results.csv");
  int counted = 0;
  for (const auto& row : table.rows) counted += row.at(table.column("rejected")).empty() ? 1 : 0;
  CHECK_TRUE(counted >= 5 && counted < 20);
  STRCMP_CONTAINS("\"until_known\":\"e:0.03\"", read_text(host + "/runs.jsonl").c_str());

  const auto series = json::parse(ran(bench.strobe({"series", host, "--json"})).out);
  CHECK_EQUAL("e:0.03", series.at("until_known").get<std::string>());
  LONGS_EQUAL(counted, series.at("counted").get<int>());
  const auto& e = series.at("quantities").at("e");
  CHECK_TRUE(e.at("expanded_uncertainty").get<double>() <= 0.03);
  CHECK_TRUE(e.at("expanded_uncertainty").get<double>() > e.at("total_sd").get<double>() * 2.0);

  const auto again = ran(bench.strobe({"fire", "--resume", "--session", host, "--plain"}));
  STRCMP_CONTAINS("enough to know e:0.03: nothing is fired", again.err.c_str());

  // What all shots share is told by the first, be it of an earlier run.
  const auto never =
      ran(bench.strobe({"fire", "--until-known", "v_td:0.0001%", "--retries", "30", "--session", host, "--plain"}), 1);
  STRCMP_CONTAINS("v_td_mps ± ", never.err.c_str());
  STRCMP_CONTAINS("cannot be had: what all shots share (calibration, ball) makes it ± ", never.err.c_str());
  LONGS_EQUAL(table.rows.size() + 1, read_csv(host + "/results.csv").rows.size());
}

TEST(Session, TheFirstCtrlCFinishesTheShotUnderWayAndTheSessionCanBeGoneOnWith) {
  ReadyRig bench(patient());
  const std::string host = bench.folder() / "host";
  Command fire = bench.strobe(
      {"fire", "--shots", "3", "--retries", "0", "--session", host, "--plain", "--spin", "zero"});
  LineWatcher watch(bench.chip_dir());
  auto first = bench.start(fire);
  CHECK(watch.wait_for("SHUTTER", 1, kLongestWait) != 0);
  first.signal(SIGINT);
  CHECK_EQUAL(ExitStatus({1, 0}), first.wait(kLongestWait));
  const std::string said = first.err();
  STRCMP_CONTAINS("finishing shot 1; press Ctrl-C again to stop at once", said.c_str());
  CHECK_TEXT(said.find("go on with: strobe fire --resume --session " + host) != std::string::npos,
             said.c_str());
  LONGS_EQUAL(1, read_csv(host + "/results.csv").rows.size());
  const std::string text = read_text(host + "/shots.txt");
  STRCMP_CONTAINS("Z  shot 1", text.c_str());
  STRCMP_CONTAINS("finishing shot 1", text.c_str());

  Command on = bench.strobe({"fire", "--resume", "--session", host, "--plain"});
  const auto resumed = ran(on);
  STRCMP_CONTAINS("3 of 3 shots counted", resumed.err.c_str());
  const auto table = read_csv(host + "/results.csv");
  int counted = 0;
  for (const auto& row : table.rows) {
    counted += row.at(table.column("rejected")).empty() ? 1 : 0;
    CHECK_EQUAL("zero", row.at(table.column("spin")));
  }
  LONGS_EQUAL(3, counted);
  const auto again = ran(on);
  STRCMP_CONTAINS("holds 3 shots that count, of 3 wanted: nothing is fired", again.err.c_str());
}

TEST(Session, CtrlBackslashStopsTheShotUnderWayAtOnce) {
  ReadyRig bench(patient());
  LineWatcher watch(bench.chip_dir());
  auto fire = bench.start(bench.fire(3, 0));
  CHECK(watch.wait_for("SHUTTER", 1, kLongestWait) != 0);
  fire.signal(SIGQUIT);
  CHECK_EQUAL(ExitStatus({1, 0}), fire.wait(kLongestWait));
  STRCMP_CONTAINS("stopping at once", fire.err().c_str());
  bench.finish();
  LONGS_EQUAL(1, read_log(bench.journal()).shots.size());
}

TEST(Session, TheWorkstationHearsThatOutputsMayBeActive) {
  ReadyRig bench;
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
  ReadyRig bench;
  run_process(bench.fire(1, 0), kLongestWait);
  run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(2, journal.shots.size());
  LONGS_EQUAL(1, journal.shots[0].shot_id);
  LONGS_EQUAL(2, journal.shots[1].shot_id);
}

TEST(Session, UsesNoShotsNumberTwiceAfterADeath) {
  RigFixtureOptions options;
  options.shell = "\"$@\"; rm \"$5\"/journal-*; \"$@\"";  // nothing of the journal had come to the disk
  ReadyRig bench(options);
  run_process(bench.fire(1, 0), kLongestWait);
  const std::filesystem::path old_journal = bench.journal();
  const pid_t guardian = bench.guardian();
  kill(bench.worker(), SIGKILL);
  CHECK(wait_until([&] { return bench.guardian() != guardian && bench.worker() != 0; }, kLongestWait));
  CHECK(wait_until([&] { return bench.journal() != old_journal; }, kLongestWait));
  run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(1, journal.shots.size());
  CHECK(journal.shots[0].shot_id > 1);
  kill(bench.guardian(), SIGTERM);
}

TEST(Session, StartsAgainBesideTheOldJournalAndGoesOnCounting) {
  RigFixtureOptions options;
  options.shell = "\"$@\"; \"$@\"";  // strobed again once it was ended
  ReadyRig bench(options);
  run_process(bench.fire(1, 0), kLongestWait);
  const std::filesystem::path old_journal = bench.journal();
  const pid_t guardian = bench.guardian();
  kill(guardian, SIGTERM);
  CHECK(wait_until([&] { return bench.guardian() != guardian && bench.worker() != 0; }, 10s));
  CHECK(wait_until([&] { return bench.journal() != old_journal; }, kLongestWait));
  run_process(bench.fire(1, 0), kLongestWait);
  const LogContents journal = read_log(bench.journal());
  LONGS_EQUAL(1, journal.shots.size());
  LONGS_EQUAL(2, journal.shots[0].shot_id);
  kill(bench.guardian(), SIGTERM);
}

// A session of the shipped programs read back: replayed from its folder, one shot shown and corrected, results.csv made
// anew, and what a killed host left behind digitized.

TEST_GROUP(SessionAgain) {
  TemporaryFolder camera;
  std::unique_ptr<RigFixture> bench;
  std::string printed;

  void fire(int shots) {
    bench = std::make_unique<RigFixture>(with_small_photographs(short_shots(), camera.path()));
    expect_ready(*bench);
    const auto fired =
        run_process(bench->fire(shots, 0, {"--photographs", camera.path()}), 240s);
    CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
    printed = fired.out;
    bench->finish();
  }
  CompletedProcess run(const std::vector<std::string>& words, int code = 0) {
    auto done = run_process(bench->strobe(words), kLongestWait);
    CHECK_TEXT(done.status == ExitStatus({code, 0}), (done.out + done.err).c_str());
    return done;
  }
  std::string results() const { return read_text(bench->session() / "results.csv"); }
};

TEST(SessionAgain, GivesWhatFireShowedAndTakesCorrections) {
  fire(2);
  const std::string session = bench->session();
  CHECK_EQUAL(readout_lines(printed), readout_lines(run({"replay", session, "--json"}).out));
  run({"replay", session, "--results", camera / "again.csv"});
  CHECK_EQUAL(results(), read_text(camera / "again.csv"));

  // The last shot counts.
  const auto fired = readouts(printed);
  const std::string name = std::to_string(fired.back().at("shot_id").get<int>());
  const auto shown = run({"shot", session, name, "--json"});
  CHECK_EQUAL(readout_lines(run({"replay", session, "--shot", name, "--json"}).out),
              readout_lines(shown.out));
  const json before = parse_json_lines(shown.out).at(1);
  CHECK_EQUAL(name, before.at("shot").get<std::string>());
  LONGS_EQUAL(1, before.at("digitizations").size());
  const std::string photograph = bench->session() / before.at("photograph").get<std::string>();
  CHECK(fs::exists(photograph));

  // An image in the middle of the way up is moved by a quarter of a pixel, another one removed.
  const auto found = run({"digitize", photograph, "--json"});
  const json images = parse_json_lines(found.out).at(0).at("images");
  const auto &removed = images.at(1).at("centre_px"), &moved = images.at(images.size() - 2).at("centre_px");
  const std::string corrections = camera / "corrections.toml";
  write_text(corrections,
             fmt::format("[[remove]]\nat_px = [{}, {}]\n[[move]]\nat_px = [{}, {}]\ncentre_px = [{}, {}]\n",
                         removed[0].get<double>(), removed[1].get<double>(), moved[0].get<double>(),
                         moved[1].get<double>(), moved[0].get<double>() + 0.25, moved[1].get<double>()));
  const auto edited =
      run({"shot", session, name, "--edit", corrections, "--json", "--overlay", camera / "shot.png"});
  const auto lines = parse_json_lines(edited.out);
  LONGS_EQUAL(2, lines.size());
  LONGS_EQUAL(2, lines[1].at("digitizations").size());
  const json& counts = lines[1].at("digitizations").at(1);
  CHECK(counts.at("counts").get<bool>());
  CHECK_EQUAL("corrected", counts.at("digitization").get<std::string>());
  LONGS_EQUAL(images.size() - 1, counts.at("images").get<std::size_t>());
  CHECK(lines[1].at("before").at("vx_td_mps") == fired.back().at("vx_td_mps"));
  CHECK(lines[0].at("vx_lo_mps") != fired.back().at("vx_lo_mps"));
  CHECK(fs::file_size(camera / "shot.png") > 0);
  CHECK_EQUAL(read_text(corrections),
              read_text(bench->session() / counts.at("corrections").get<std::string>()));
  // The same bytes of images as `strobe digitize` gives, but for times, which it was not told.
  const auto alone = run({"digitize", photograph, "--edit", corrections, "--json"});
  json expected = parse_json_lines(alone.out).at(0).at("images");
  json kept = read_json_lines(bench->session() / counts.at("file").get<std::string>()).at(0).at("images");
  for (json* each : {&expected, &kept})
    for (json& image : *each) image.erase("time_s"), image.erase("flash_index");
  CHECK_EQUAL(expected.dump(), kept.dump());

  // Given twice it is kept once.
  const auto twice = run({"shot", session, name, "--edit", corrections, "--json"});
  CHECK_EQUAL(readout_lines(edited.out), readout_lines(twice.out));
  LONGS_EQUAL(1, files_ending(bench->session() / "digitizations", ".json"));
  // The table follows it.
  run({"replay", session, "--results"});
  CHECK(results().find(",corrected," + name + ",") != std::string::npos);
  LONGS_EQUAL(std::ranges::count(read_text(camera / "again.csv"), '\n'), std::ranges::count(results(), '\n'));
  CHECK(readout_lines(run({"replay", session, "--json"}).out) != readout_lines(printed));
  // And back.
  run({"shot", session, name, "--undo-edit"});
  run({"shot", session, name, "--undo-edit"}, 2);
  CHECK_EQUAL(readout_lines(printed), readout_lines(run({"replay", session, "--json", "--results"}).out));
  CHECK_EQUAL(read_text(camera / "again.csv"), results());
}

TEST(SessionAgain, DigitizesWhatAKilledHostLeft) {
  fire(1);
  const std::string session = bench->session();
  const std::string table = results();
  cut_before_the_first_frame(host_log(bench->session()));
  fs::remove(bench->session() / "results.csv");
  const auto left = run({"replay", session, "--json"});
  LONGS_EQUAL(readouts(printed).size(), readouts(left.out).size());
  CHECK(has_flag(readouts(left.out).front(), "no_photograph"));
  CHECK_TEXT(left.err.find("strobe replay " + session + " --complete") != std::string::npos,
             left.err.c_str());
  const auto completed = run({"replay", session, "--json", "--complete", "--results"});
  CHECK_EQUAL(without_verified(printed), without_verified(completed.out));
  // But for the times of the results, the first column, it is the table that was lost.
  const auto untimed = [](const std::string& text) {
    std::string lines;
    for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
      lines += text.substr(text.find(',', at), text.find('\n', at) - text.find(',', at)) + "\n";
    return lines;
  };
  CHECK_EQUAL(untimed(table), untimed(results()));
  // Nothing is left to be done.
  const auto again = run({"replay", session, "--json", "--complete"});
  CHECK_EQUAL(completed.out, again.out);
  STRCMP_CONTAINS("0 photographs digitized", again.err.c_str());
}

TEST(SessionAgain, AJournalAloneHasItsShotsWithoutPhotographs) {
  fire(1);
  const auto alone = run({"replay", bench->journal(), "--json"});
  LONGS_EQUAL(readouts(printed).size(), readouts(alone.out).size());
  for (const json& readout : readouts(alone.out)) CHECK(has_flag(readout, "no_photograph"));
}
