// Sessions as standard LCM logs: recorded, played back, recomputed to the same bytes; and never executed again.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <map>
#include <set>
#include <string>

#include "tests/hil/raw_host.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;

namespace {

Command logger(const RigFixture& bench, const std::filesystem::path& log) {
  return {{"lcm-logger", "--quiet", "--lcm-url=" + bench.lcm_url(), log}, environment_of_chip(bench.chip_dir()), {}, {}};
}

Command player(const RigFixture& bench, const std::filesystem::path& log) {
  return {{"lcm-logplayer", "--lcm-url=" + bench.lcm_url(), log}, environment_of_chip(bench.chip_dir()), {}, {}};
}

/// Shots of which a recording holds both the summary and the measured photograph.
std::set<int> whole_shots(const std::filesystem::path& log) {
  const LogContents contents = read_log(log);
  std::set<int> summarized, whole;
  for (const auto& shot : contents.shots) summarized.insert(shot.shot_id);
  for (const auto& frame : contents.frames)
    if (summarized.contains(frame.shot_id)) whole.insert(frame.shot_id);
  return whole;
}

/// Readouts of those shots in their order, without the flag events_missing: lcm-logger's queue holds 30
/// messages and drops more in silence, so that a recording of its own may lack events of a burst, or a shot's
/// summary or photograph on a machine that stood still. What was measured of the others may not change by
/// that.
std::string measured(const std::string& out, const std::set<int>& shots) {
  std::map<int, std::string> lines;
  for (nlohmann::json readout : readouts(out)) {
    if (!shots.contains(readout.at("shot_id").get<int>())) continue;
    auto& flags = readout.at("flags");
    flags.erase(std::remove(flags.begin(), flags.end(), "events_missing"), flags.end());
    lines[readout.at("shot_id").get<int>()] += readout.dump() + "\n";
  }
  std::string all;
  for (const auto& [shot, line] : lines) all += line;
  return all;
}

/// Waits until a recorder has written something: it hears the bench.
bool hears(const std::filesystem::path& log) {
  return wait_until(
      [&] {
        std::error_code error;
        return std::filesystem::file_size(log, error) > 0 && !error;
      },
      kLongestWait);
}

/// Messages of a kind that a recorder has written so far.
std::size_t recorded(const std::filesystem::path& log, const std::string& kind) {
  const std::string bytes = read_text(log);
  std::size_t count = 0;
  for (std::size_t at = bytes.find(kind); at != std::string::npos; at = bytes.find(kind, at + 1)) ++count;
  return count;
}

/// Fires shots while lcm-logger listens; returns what strobe printed.
std::string record_session(RigFixture& bench, int shots, const std::filesystem::path& log) {
  Process recorder = bench.start(logger(bench, log));
  CHECK(hears(log));  // the firmware's heartbeat
  const auto fired = ran(bench.fire(shots, 0));
  const std::size_t sent = readouts(fired.out).size();
  // What its queue has dropped it never writes.
  LineWatcher(bench.chip_dir()).wait_until([&] { return recorded(log, "/READOUT") >= sent; }, 3s);
  recorder.signal(SIGINT);
  CHECK(recorder.wait(kLongestWait).has_value());
  return fired.out;
}

}  // namespace

TEST_GROUP(Log){};

TEST(Log, RecordedAndPlayedBackShowsTheSameNumbers) {
  ReadyRig bench(short_shots());
  const std::string fired = record_session(bench, 2, bench.folder() / "recorded.lcmlog");
  bench.finish();
  const std::set<int> whole = whole_shots(bench.folder() / "recorded.lcmlog");
  const std::string expected = measured(fired, whole);
  CHECK(!expected.empty());
  const auto replayed = ran(bench.strobe({"replay", bench.folder() / "recorded.lcmlog", "--json"}));
  CHECK_EQUAL(expected, measured(replayed.out, whole));

  Process live = bench.start(bench.strobe({"live", "--json"}));
  CHECK(live.wait_for_err("listening to rig", kLongestWait));
  const auto played = ran(player(bench, bench.folder() / "recorded.lcmlog"));
  wait_until([&] { return measured(live.out(), whole).size() >= expected.size(); }, kLongestWait);
  live.signal(SIGINT);
  CHECK(live.wait(kLongestWait).has_value());
  CHECK_EQUAL(expected, measured(live.out(), whole));
}

TEST(Log, OfTheSessionsFolderIsRecomputedToTheSameBytes) {
  ReadyRig bench(short_shots());
  const auto fired = ran(bench.fire(2, 0));
  bench.finish();
  const std::filesystem::path log = host_log(bench.session());
  CHECK(!log.empty());
  const auto replayed = ran(bench.strobe({"replay", log, "--json"}));
  CHECK_EQUAL(readout_lines(fired.out), readout_lines(replayed.out));
}

TEST(Log, WithCommandsInItNeverFiresARigAgain) {
  ReadyRig first(short_shots());
  const std::filesystem::path log = first.folder() / "recorded.lcmlog";
  record_session(first, 1, log);
  CHECK(read_log(log).commands >= 2);

  // The same daemon, armed again by another host: its boot id is right, its tokens are spent.
  RawHost host(first);
  CHECK(host.wait_status());
  CHECK(host.arm() != 0);
  const std::int64_t before = LineWatcher(first.chip_dir()).now_ns();
  run_process(player(first, log), kLongestWait);
  host.listen(1s);
  const LineChanges changes = first.finish();
  for (const std::string& output : kOutputs) LONGS_EQUAL(0, changes.rises(output, before));

  // Another daemon, another boot, armed as well.
  ReadyRig second(short_shots());
  RawHost other(second);
  CHECK(other.wait_status());
  CHECK(other.arm() != 0);
  run_process(player(second, log), kLongestWait);
  other.listen(1s);
  const LineChanges untouched = second.finish();
  for (const std::string& output : kOutputs) LONGS_EQUAL(0, untouched.rises(output));
}

TEST(Log, OfAListenerThatJoinsLateHoldsTheShotsBeforeItAndThoseToCome) {
  ReadyRig bench(short_shots());
  const auto before = ran(bench.fire(1, 0));
  Process live = bench.start(bench.strobe({"live", "--json"}));
  // The journal is asked for what was; whoever measured its photographs sends them again.
  const std::size_t past = readouts(before.out).size();
  CHECK(wait_until([&] { return readouts(live.out()).size() >= past; }, kLongestWait));
  const auto fired = ran(bench.fire(1, 0));
  const std::vector<nlohmann::json> expected = readouts(fired.out);
  wait_until([&] { return readouts(live.out()).size() >= past + expected.size(); }, kLongestWait);
  live.signal(SIGINT);
  CHECK(live.wait(kLongestWait).has_value());
  CHECK_EQUAL(readout_lines(before.out) + readout_lines(fired.out), readout_lines(live.out()));
}
