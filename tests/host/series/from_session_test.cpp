// Stored sessions as series take them.
#include "host/series/from_session.hpp"

#include <cmath>

#include "host/series/series.hpp"
#include "host/session/shot_result.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::host_test;
using reduction::Quantity;

namespace {

RigFile rig_of(double px_per_m) {
  RigFile rig;
  rig.machine_lag_s = kMachineLag_s;
  rig.analysis.flash_time_sd_s = 0.2e-6;
  rig.analysis.px_per_m = px_per_m;
  rig.analysis.px_per_m_sd = 10.0;
  return rig;
}

StoredShot stored(std::uint32_t seed, const std::shared_ptr<const RigFile>& rig, const std::string& ball) {
  Scenario scenario;
  scenario.seed = seed;
  const SyntheticShot made = make_shot(scenario);
  StoredShot shot;
  shot.name = std::to_string(seed);
  shot.summary = made.shot;
  shot.digitizations.emplace_back().frame = made.frame;
  shot.result = measured_result(made.shot, made.frame, {}, assembly_settings(*rig));
  shot.rig = rig;
  if (!ball.empty()) shot.result.readout.record["ball_name"] = ball;
  return shot;
}

StoredSession session_of(double px_per_m, const std::string& ball = "") {
  StoredSession session;
  session.rig = rig_of(px_per_m);
  const auto rig = std::make_shared<const RigFile>(session.rig);
  for (const std::uint32_t seed : {1U, 2U, 3U}) session.shots.push_back(stored(seed, rig, ball));
  return session;
}

/// px per m of the synthetic photographs.
double true_scale() {
  const SyntheticShot made = make_shot({});
  return made.frame.images.front().diameter_px / kBallDiameter_m;
}

}  // namespace

TEST_GROUP(SeriesOfASession){};

TEST(SeriesOfASession, HasEachShotWithItsBudget) {
  const auto shots = series_shots(session_of(true_scale()), "run1");
  CHECK_EQUAL(3U, shots.size());
  CHECK_EQUAL(std::string("run1:2"), shots[1].full_name());
  for (const SeriesShot& shot : shots) {
    CHECK_FALSE(shot.rejected.has_value());
    CHECK_FALSE(shot.budget.sources.empty());
    // The lines are the readout's sds: to what a mixture's other assignments change.
    const double sd = std::hypot(*shot.readout.sd[Quantity::vx_td_mps],
                                 shot.readout.sd_systematic[Quantity::vx_td_mps].value_or(0.0));
    double combined = 0.0;
    for (const auto& line : shot.budget.sources)
      combined = std::hypot(combined, line.of(Quantity::vx_td_mps));
    DOUBLES_EQUAL(1.0, combined / sd, 0.01);
  }
}

TEST(SeriesOfASession, SharesCalibrationAndBallWithAnotherOfTheSameRigFile) {
  const double scale = true_scale();
  const auto one = series_shots(session_of(scale), "a"), same = series_shots(session_of(scale), "b");
  CHECK_TRUE(one[0].calibration == same[0].calibration && one[0].ball == same[0].ball);
  CHECK_TRUE(one[0].calibration != series_shots(session_of(scale + 1.0), "c")[0].calibration);
  const auto named = series_shots(session_of(scale, "ball 7"), "d");
  CHECK_TRUE(one[0].calibration == named[0].calibration && one[0].ball != named[0].ball);
}

TEST(SeriesOfASession, CountsARejectedShotWithoutABudget) {
  StoredSession session = session_of(true_scale());
  session.shots[1].result.rejected = "the photograph did not come in time";
  session.shots[1].digitizations.clear();
  const auto shots = series_shots(session, "");
  CHECK_TRUE(shots[1].budget.sources.empty());
  const SeriesSummary summary = summarize("", shots);
  CHECK_EQUAL(2, summary.counted);
  CHECK_EQUAL(1, summary.rejected);
  CHECK_FALSE(matched_frame(session.shots[1]).has_value());
  CHECK_TRUE(matched_frame(session.shots[0])->images.size() > 5);
}
