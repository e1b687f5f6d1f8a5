// From the camera's photograph to the readout, with the shipped programs: photographs rendered as the shutter
// closes, found in the folder, matched, digitized, reduced; recomputed from the log without them.
#include <cmath>
#include <filesystem>
#include <string>

#include "tests/hil/expect_ready.hpp"
#include "tests/hil/rig_fixture.hpp"
#include "tests/hil/short_shots.hpp"
#include "tests/hil/truth_score.hpp"
#include "tests/support/json_lines.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe::hil;
using namespace std::chrono_literals;
using strobe::testing::ExitStatus;

namespace {

int files_in(const std::filesystem::path& folder) {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

/// Share of the incoming speed by which the velocities are off. A centre that is off by a whole pixel at both
/// ends of a leg of four images would make 2 %.
double worst_share(const nlohmann::json& readout, const nlohmann::json& truth) {
  double worst = 0.0;
  for (const char* name : {"vx_td_mps", "vy_td_mps", "vx_lo_mps", "vy_lo_mps"}) {
    const double error = readout.at(name).get<double>() - truth.at("readout").at(name).get<double>();
    worst = std::max(worst, std::abs(error) / truth.at("readout").at("v_td_mps").get<double>());
  }
  return worst;
}

}  // namespace

TEST_GROUP(Photographs){};

TEST(Photographs, AreReadOutAsTheyArriveAndAJunkFileStopsNothing) {
  const strobe::testing::TemporaryFolder camera;
  strobe::testing::write_text(camera / "old.tif", "of another day");
  RigFixture bench(with_small_photographs(short_shots(), camera.path()));
  expect_ready(bench);
  auto fire = bench.start(bench.fire(2, 0, {"--photographs", camera.path(), "--effort", "fast"}));
  CHECK(fire.wait_for_err("photographs from", kLongestWait));
  strobe::testing::write_text(camera / "junk.tif", "no photograph");
  const auto status = fire.wait(240s);
  CHECK_TEXT(status == ExitStatus({0, 0}), fire.err().c_str());
  CHECK_TEXT(fire.err().find("junk.tif") != std::string::npos, fire.err().c_str());
  CHECK_TEXT(fire.err().find("coded train: intervals of 3000 to ") != std::string::npos, fire.err().c_str());
  CHECK_TEXT(fire.err().find("old.tif") == std::string::npos, fire.err().c_str());
  const std::string printed = fire.out();
  bench.finish();

  int good = 0;
  for (const auto& readout : readouts(printed)) {
    if (is_rejected(readout) || !is_complete(readout)) continue;
    for (const auto& truth : bench.truths()) {
      if (truth.at("shot_id") != readout.at("shot_id")) continue;
      ++good;
      // The shipped plan's train: its intervals tell the flashes.
      CHECK_TEXT(readout.at("misassignment_probability").get<double>() < 0.01, readout.dump().c_str());
      CHECK_TEXT(worst_share(readout, truth) < 0.02, readout.dump().c_str());
    }
  }
  CHECK(good >= 1);
  const std::string plan = strobe::testing::read_text(bench.session() / "plan.toml");
  CHECK_TEXT(plan.find("intervals_us = [3000, ") != std::string::npos, plan.c_str());
  CHECK(files_in(bench.session() / "photographs") >= 2);

  std::filesystem::remove_all(bench.session() / "photographs");
  const auto replayed = strobe::testing::run_process(
      bench.strobe({"replay", host_log(bench.session()), "--json"}), kLongestWait);
  CHECK_TEXT(replayed.status == ExitStatus({0, 0}), replayed.err.c_str());
  CHECK_EQUAL(readout_lines(printed), readout_lines(replayed.out));
}
