// strobe batch: the photographs of many sessions measured again. However the work is divided, stopped and gone on with, the
// results are the same bytes. And what results.csv holds is in the JSON, too.
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/config/notes.hpp"
#include "host/session/shot_table.hpp"
#include "tests/host/others/stored_photographs.hpp"
#include "tests/support/program_run.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

constexpr const char* kStrobe = STROBE_BUILD_DIR "/bin/strobe";
constexpr int kShots = 5;  // of both sessions

/// Rendered once for all tests; none of them changes it.
others::StoredPhotographs& stored() {
  static others::StoredPhotographs sessions;
  static const bool once = [] {
    sessions.add_session("monday", "zero_23", 3);
    sessions.add_session("tuesday", "top_42", 2);
    return true;
  }();
  static_cast<void>(once);
  return sessions;
}

std::vector<std::string> both() { return {stored().path() / "monday", stored().path() / "tuesday"}; }

testing::Command batch(std::vector<std::string> words) {
  words.insert(words.begin(), {kStrobe, "batch", "--effort", "fast"});
  return {.arguments = std::move(words), .environment = {{"STROBE_KEY_FILE", stored().key_file()}}};
}

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::size_t lines_in(const fs::path& file) {
  const std::string text = testing::read_text(file);
  return static_cast<std::size_t>(std::ranges::count(text, '\n'));
}

/// Of a table whose cells need no quotes, without its first line.
std::string cell(const testing::CsvTable& table, std::size_t row, const char* column) {
  return table.rows.at(row).at(table.column(column));
}

/// Where the JSON of a result has the column; notes are in its record if they were made.
nlohmann::json::json_pointer place_of(const std::string& column) {
  for (const std::string prefix : {"sd_systematic_", "sd_"}) {
    if (column.starts_with(prefix))
      return nlohmann::json::json_pointer("/" + prefix.substr(0, prefix.size() - 1) + "/" +
                                          column.substr(prefix.size()));
  }
  const bool note =
      std::ranges::find(host::kNamedNotes, column) != host::kNamedNotes.end() || column == "other_notes";
  return nlohmann::json::json_pointer(note ? "/record" : "/" + column);
}

}  // namespace

TEST_GROUP(Batch) {
  testing::TemporaryFolder out;

  testing::CompletedProcess run(const std::vector<std::string>& words, int status = 0) {
    auto finished = testing::run_process(batch(words), 100s);
    LONGS_EQUAL_TEXT(status, finished.status->code, finished.err.c_str());
    return finished;
  }
  testing::CompletedProcess run_both(const char* folder, const std::vector<std::string>& more,
                                     int status = 0) {
    return run(joined(joined(both(), {"--out", out / folder}), more), status);
  }
  std::string results(const char* folder) { return testing::read_text(out / folder / "results.csv"); }
  /// How many rows the batch measured, by its last line of JSON.
  int measured(const testing::CompletedProcess& finished) {
    return testing::parse_json_lines(finished.out).back().at("measured").get<int>();
  }
  /// Starts it and returns once a row is stored.
  void start_and(const char* folder, int signal, int status) {
    testing::Process process(batch(joined(both(), {"--out", out / folder, "--jobs", "1"})), out.path());
    CHECK(testing::wait_until([&] { return lines_in(out / folder / "done.jsonl") > 0; }, 60s));
    process.signal(signal);
    const auto ended = process.wait(60s);
    CHECK_TRUE(ended.has_value());
    LONGS_EQUAL(signal == SIGKILL ? SIGKILL : 0, ended->signal);
    if (signal != SIGKILL) LONGS_EQUAL(status, ended->code);
    CHECK(lines_in(out / folder / "done.jsonl") < kShots);
    CHECK_FALSE(fs::exists(out / folder / "results.csv"));
  }
};

TEST(Batch, MeasuresEveryKeptPhotographWithNumbersThatTheSceneHas) {
  const auto finished = run_both("a", {"--jobs", "1", "--json"});
  LONGS_EQUAL(kShots, measured(finished));
  LONGS_EQUAL(kShots + 1, testing::parse_json_lines(finished.out).size());
  const auto table = testing::read_csv(out / "a/results.csv");
  LONGS_EQUAL(kShots, table.rows.size());
  for (std::size_t i = 0; i < kShots; ++i) {
    CHECK_EQUAL(i < 3 ? "monday" : "tuesday", cell(table, i, "session"));
    CHECK_EQUAL("photograph", cell(table, i, "digitized"));
    // Balls of both scenes come in fast and leave with e between 0.7 and 0.95, see common/data/thesis.
    const double e = std::stod(cell(table, i, "e"));
    CHECK_TEXT(e > 0.7 && e < 0.95, cell(table, i, "e").c_str());
  }
  CHECK_EQUAL("photographs/shot-0002-camera.tif", cell(table, 1, "photograph"));
  LONGS_EQUAL(3 + 1, lines_in(out / "a/monday.csv"));
  CHECK_TRUE(fs::exists(out / "a/results.csv-metadata.json"));
}

TEST(Batch, PrintsEveryColumn) {
  const auto finished = run({stored().path() / "tuesday", "--out", out / "a", "--json"});
  const auto row = testing::parse_json_lines(finished.out).at(0);
  for (const std::string& column : testing::read_csv(out / "a/results.csv").columns)
    CHECK_TEXT(row.contains(column), column.c_str());
  CHECK_TRUE(row.at("e").is_number());
}

TEST(Batch, GivesTheSameBytesWithOneJobAndWithTwo) {
  run_both("one", {"--jobs", "1"});
  run_both("two", {"--jobs", "2"});
  CHECK_EQUAL(results("one"), results("two"));
  CHECK_EQUAL(testing::read_text(out / "one/tuesday.csv"), testing::read_text(out / "two/tuesday.csv"));
}

TEST(Batch, MeasuresNothingTwice) {
  run_both("a", {});
  const std::string first = results("a");
  LONGS_EQUAL(0, measured(run_both("a", {"--json"})));
  CHECK_EQUAL(first, results("a"));
  LONGS_EQUAL(kShots, lines_in(out / "a/done.jsonl"));
}

TEST(Batch, GoesOnAfterAKillWithTheSameBytes) {
  run_both("whole", {});
  start_and("killed", SIGKILL, 0);
  const auto stored_rows = static_cast<int>(lines_in(out / "killed/done.jsonl"));
  // A kill, or a full disk, may leave a part of a line.
  testing::write_text(out / "killed/done.jsonl",
                      testing::read_text(out / "killed/done.jsonl") + "{\"key\":\"12");
  LONGS_EQUAL(kShots - stored_rows, measured(run_both("killed", {"--json"})));
  CHECK_EQUAL(results("whole"), results("killed"));
}

TEST(Batch, GoesOnAfterCtrlC) {
  run_both("whole", {});
  start_and("stopped", SIGINT, 1);
  run_both("stopped", {});
  CHECK_EQUAL(results("whole"), results("stopped"));
}

TEST(Batch, MergesPartsOfSeveralMachinesToTheSameBytes) {
  run_both("whole", {});
  const std::string first = out / "first", second = out / "second", merged = out / "merged";
  run(joined(both(), {"--out", first, "--shard", "1/2"}));
  run(joined(both(), {"--out", second, "--shard", "2/2"}));
  const auto early = run({"--merge", first, "--out", merged}, 2);
  CHECK_EQUAL("strobe: batch: 1 of 2 sessions are not finished: tuesday\n", early.err);
  run({"--merge", first, second, "--out", merged});
  CHECK_EQUAL(results("whole"), results("merged"));
}

TEST(Batch, RunsUnderGnuParallelWithTheSameBytes) {
  if (!fs::exists("/usr/bin/parallel")) return std::printf("not run: needs Debian's parallel\n"), void();
  run_both("whole", {});
  testing::write_text(out / "all.txt", "# sessions\n" + both()[0] + "\n\n" + both()[1] + "\n");
  const std::string shard = out / "shards";
  const auto finished = testing::run_process(
      {.arguments = {"/usr/bin/parallel", "--will-cite", kStrobe, "batch", "--effort", "fast", "--list",
                     out / "all.txt", "--out", shard, "--jobs", "1", "--shard", "{}/2", ":::", "1", "2"},
       .environment = {{"STROBE_KEY_FILE", stored().key_file()}, {"HOME", out.path()}}},
      100s);
  LONGS_EQUAL_TEXT(0, finished.status->code, finished.err.c_str());
  run({"--merge", shard});
  CHECK_EQUAL(results("whole"), results("shards"));
}

TEST(Batch, MeasuresAgainWithAnotherCalibration) {
  testing::write_text(out / "camera.toml", "px_per_m = 1515.0\npx_per_m_sd = 0.15\n");
  run_both("a", {});
  const auto before = testing::read_csv(out / "a/results.csv");
  LONGS_EQUAL(kShots, measured(run_both("a", {"--calibration", out / "camera.toml", "--json"})));
  const auto after = testing::read_csv(out / "a/results.csv");
  // Lengths are 1 % shorter. Where ball and scale disagree both count by their sds, so that it is less.
  CHECK(std::stod(cell(after, 0, "v_td_mps")) < std::stod(cell(before, 0, "v_td_mps")));
  LONGS_EQUAL(0, measured(run_both("a", {"--json"})));
}

TEST(Batch, GivesAPhotographThatFailsARowWithItsReason) {
  others::StoredPhotographs damaged;
  const fs::path session = damaged.add_session("damaged", "zero_23", 2);
  testing::write_text(session / "photographs/shot-0001-camera.tif", "no picture");
  const auto finished = testing::run_process(batch({session, "--out", out / "a"}), 100s);
  LONGS_EQUAL(1, finished.status->code);
  const auto table = testing::read_csv(out / "a/results.csv");
  LONGS_EQUAL(2, table.rows.size());
  STRCMP_CONTAINS("photograph not measured: ", cell(table, 0, "rejected").c_str());
  CHECK_EQUAL("", cell(table, 0, "e"));
  CHECK_EQUAL("", cell(table, 1, "rejected"));
}

TEST(Batch, GivesASessionThatCannotBeReadARowWithItsReason) {
  const auto finished = run(joined(both(), {out / "nowhere", "--out", out / "a"}), 1);
  STRCMP_CONTAINS("1 sessions cannot be read", finished.err.c_str());
  const std::string table = results("a");
  STRCMP_CONTAINS("session not read: ", table.c_str());
  LONGS_EQUAL(kShots + 2, lines_in(out / "a/results.csv"));
}

TEST(Batch, RefusesWhatItCannotDo) {
  check_refused(run({"--out", out / "a"}, 2), "batch: no session is given");
  check_refused(run_both("a", {"--shard", "3/2"}, 2), "batch: --shard 3/2: must be I/N with I from 1 to N, such as 3/8");
  check_refused(
      run_both("a", {"--frames", "--calibration", "camera.toml"}, 2),
      "batch: --frames keeps the calibration that the frames were digitized with; leave --calibration out");
  const auto no_rig = run_both("a", {"--rig", out / "none.toml"}, 2);
  STRCMP_CONTAINS("none.toml", no_rig.err.c_str());
}

TEST_GROUP(JsonOfResults){};

TEST(JsonOfResults, HoldsEveryColumnThatALogTells) {
  const fs::path session = stored().path() / "monday";
  const auto results =
      jsons_of(testing::run_program({kStrobe, "replay", session / "host-20260131T093000Z.lcmlog", "--json"},
                                    {{"STROBE_KEY_FILE", stored().key_file()}}));
  LONGS_EQUAL(3, results.size());
  for (const host::Column& column : host::results_columns()) {
    // A log's readouts are the same bytes whenever they are computed, and whatever its session calls its shots and made
    // of them afterwards; Batch.PrintsEveryColumn has these columns.
    if (column.name == "utc" || column.name == "shot" || column.name == "digitization") continue;
    // A result has `spatial` only where its photograph tells of the third dimension.
    if (std::ranges::any_of(reduction::kSpatialNames, [&](auto name) { return column.name.ends_with(name); })) continue;
    CHECK_TEXT(results[0].contains(place_of(column.name)), column.name.c_str());
  }
}
