// A session of the shipped programs read back: replayed from its folder, one shot shown and corrected, results.csv made
// anew, and what a killed host left behind digitized.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "common/wire/log_reader.hpp"
#include "tests/hil/expect_ready.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;
using nlohmann::json;
using strobe::testing::ExitStatus;
namespace fs = std::filesystem;

namespace {

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

TEST_GROUP(SessionAgain) {
  strobe::testing::TemporaryFolder camera;
  std::unique_ptr<RigFixture> bench;
  std::string printed;

  void fire(int shots) {
    bench = std::make_unique<RigFixture>(with_small_photographs(short_shots(), camera.path()));
    expect_ready(*bench);
    const auto fired =
        strobe::testing::run_process(bench->fire(shots, 0, {"--photographs", camera.path()}), 240s);
    CHECK_TEXT(fired.status == ExitStatus({0, 0}), fired.err.c_str());
    printed = fired.out;
    bench->finish();
  }
  strobe::testing::CompletedProcess run(const std::vector<std::string>& words, int code = 0) {
    auto done = strobe::testing::run_process(bench->strobe(words), kLongestWait);
    CHECK_TEXT(done.status == ExitStatus({code, 0}), (done.out + done.err).c_str());
    return done;
  }
  std::string results() const { return strobe::testing::read_text(bench->session() / "results.csv"); }
};

TEST(SessionAgain, GivesWhatFireShowedAndTakesCorrections) {
  fire(2);
  const std::string session = bench->session();
  CHECK_EQUAL(readout_lines(printed), readout_lines(run({"replay", session, "--json"}).out));
  run({"replay", session, "--results", camera / "again.csv"});
  CHECK_EQUAL(results(), strobe::testing::read_text(camera / "again.csv"));

  // The last shot counts.
  const auto fired = readouts(printed);
  const std::string name = std::to_string(fired.back().at("shot_id").get<int>());
  const auto shown = run({"shot", session, name, "--json"});
  CHECK_EQUAL(readout_lines(run({"replay", session, "--shot", name, "--json"}).out),
              readout_lines(shown.out));
  const json before = strobe::testing::parse_json_lines(shown.out).at(1);
  CHECK_EQUAL(name, before.at("shot").get<std::string>());
  LONGS_EQUAL(1, before.at("digitizations").size());
  const std::string photograph = bench->session() / before.at("photograph").get<std::string>();
  CHECK(fs::exists(photograph));

  // An image in the middle of the way up is moved by a quarter of a pixel, another one removed.
  const auto found = run({"digitize", photograph, "--json"});
  const json images = strobe::testing::parse_json_lines(found.out).at(0).at("images");
  const auto &removed = images.at(1).at("centre_px"), &moved = images.at(images.size() - 2).at("centre_px");
  const std::string corrections = camera / "corrections.toml";
  strobe::testing::write_text(
      corrections,
      fmt::format("[[remove]]\nat_px = [{}, {}]\n[[move]]\nat_px = [{}, {}]\ncentre_px = [{}, {}]\n",
                  removed[0].get<double>(), removed[1].get<double>(), moved[0].get<double>(),
                  moved[1].get<double>(), moved[0].get<double>() + 0.25, moved[1].get<double>()));
  const auto edited =
      run({"shot", session, name, "--edit", corrections, "--json", "--overlay", camera / "shot.png"});
  const auto lines = strobe::testing::parse_json_lines(edited.out);
  LONGS_EQUAL(2, lines.size());
  LONGS_EQUAL(2, lines[1].at("digitizations").size());
  const json& counts = lines[1].at("digitizations").at(1);
  CHECK(counts.at("counts").get<bool>());
  CHECK_EQUAL("corrected", counts.at("digitization").get<std::string>());
  LONGS_EQUAL(images.size() - 1, counts.at("images").get<std::size_t>());
  CHECK(lines[1].at("before").at("vx_td_mps") == fired.back().at("vx_td_mps"));
  CHECK(lines[0].at("vx_lo_mps") != fired.back().at("vx_lo_mps"));
  CHECK(fs::file_size(camera / "shot.png") > 0);
  CHECK_EQUAL(strobe::testing::read_text(corrections),
              strobe::testing::read_text(bench->session() / counts.at("corrections").get<std::string>()));
  // The same bytes of images as `strobe digitize` gives, but for times, which it was not told.
  const auto alone = run({"digitize", photograph, "--edit", corrections, "--json"});
  json expected = strobe::testing::parse_json_lines(alone.out).at(0).at("images");
  json kept = strobe::testing::read_json_lines(bench->session() / counts.at("file").get<std::string>())
                  .at(0)
                  .at("images");
  for (json* each : {&expected, &kept})
    for (json& image : *each) image.erase("time_s"), image.erase("flash_index");
  CHECK_EQUAL(expected.dump(), kept.dump());

  // Given twice it is kept once.
  const auto twice = run({"shot", session, name, "--edit", corrections, "--json"});
  CHECK_EQUAL(readout_lines(edited.out), readout_lines(twice.out));
  LONGS_EQUAL(1, files_ending(bench->session() / "digitizations", ".json"));
  // The table follows it.
  run({"replay", session, "--results"});
  CHECK(results().find(",corrected," + name + "\n") != std::string::npos);
  LONGS_EQUAL(std::ranges::count(strobe::testing::read_text(camera / "again.csv"), '\n'),
              std::ranges::count(results(), '\n'));
  CHECK(readout_lines(run({"replay", session, "--json"}).out) != readout_lines(printed));
  // And back.
  run({"shot", session, name, "--undo-edit"});
  run({"shot", session, name, "--undo-edit"}, 2);
  CHECK_EQUAL(readout_lines(printed), readout_lines(run({"replay", session, "--json", "--results"}).out));
  CHECK_EQUAL(strobe::testing::read_text(camera / "again.csv"), results());
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
  CHECK_TEXT(again.err.find("0 photographs digitized") != std::string::npos, again.err.c_str());
}

TEST(SessionAgain, AJournalAloneHasItsShotsWithoutPhotographs) {
  fire(1);
  const auto alone = run({"replay", bench->journal(), "--json"});
  LONGS_EQUAL(readouts(printed).size(), readouts(alone.out).size());
  for (const json& readout : readouts(alone.out)) CHECK(has_flag(readout, "no_photograph"));
}
