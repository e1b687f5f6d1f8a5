// Which shots make a series.
#include <cmath>

#include "host/series/select.hpp"
#include "host/series/series.hpp"
#include "host/session/shot.hpp"
#include "tests/host/series/simulated_series.hpp"
#include "tests/host/synthetic_shot.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::host;
using namespace strobe::test;

namespace {

Shot noted(const std::string& session, const std::string& name, const std::string& spin,
                 const std::string& angle) {
  Shot shot = series_shot(name, 10.0);
  shot.session = session;
  shot.readout.record["spin"] = spin;
  if (!angle.empty()) shot.readout.record["angle_deg"] = angle;
  return shot;
}

std::vector<Shot> shots() {
  return {noted("a", "1", "zero", "23"), noted("a", "2", "top", "18"), noted("b", "1", "zero", "9"),
          noted("b", "3", "zero", "23.0"), noted("b", "4", "zero", "")};
}

std::string names(const ShotGroup& group) {
  std::string all = group.name + ":";
  for (const Shot& shot : group.shots) all += " " + shot.full_name();
  return all;
}

SelectedShots selected(const Selection& selection) {
  auto result = select_shots(shots(), selection);
  if (!result) FAIL(result.error().message.c_str());
  return *result;
}

std::string complaint(const Selection& selection) {
  return testing::error_of(select_shots(shots(), selection));
}

}  // namespace

TEST_GROUP(Selection){};

TEST(Selection, IsOneGroupForEachConditionUnlessAskedOtherwise) {
  const SelectedShots all = selected({});
  CHECK_EQUAL(4U, all.groups.size());
  for (const ShotGroup& group : all.groups) CHECK(group.mixed.empty());
}

TEST(Selection, IsOneGroupOverWhatMayDiffer) {
  const SelectedShots all = selected({.over = {"spin", "angle"}});
  CHECK_EQUAL(1U, all.groups.size());
  CHECK_EQUAL(std::string(": a:1 a:2 b:1 b:3 b:4"), names(all.groups[0]));
  CHECK(all.groups[0].mixed == (std::vector<std::string>{"spin", "angle_deg"}));
}

TEST(Selection, GroupsByNotesWithNumbersInTheirOrder) {
  const SelectedShots all = selected({.by = {"spin", "angle"}});
  CHECK_EQUAL(4U, all.groups.size());
  CHECK_EQUAL(std::string("top 18: a:2"), names(all.groups[0]));
  CHECK_EQUAL(std::string("zero 9: b:1"), names(all.groups[1]));
  CHECK_EQUAL(std::string("zero 23: a:1 b:3"), names(all.groups[2]));
  CHECK_EQUAL(std::string("zero (no angle_deg): b:4"), names(all.groups[3]));
}

TEST(Selection, GroupsBySessions) {
  const SelectedShots all = selected({.by = {"session"}});
  CHECK_EQUAL(std::string("b: b:1 b:3 b:4"), names(all.groups[1]));
}

TEST(Selection, FiltersByNotesAndCountsTheOthers) {
  const SelectedShots some = selected({.where = {{"spin", "zero"}, {"angle_deg", "23"}}});
  CHECK_EQUAL(std::string(": a:1 b:3"), names(some.groups[0]));
  CHECK_EQUAL(3, some.other);
}

TEST(Selection, LeavesShotsOutByName) {
  const SelectedShots some = selected({.without = {"3", "a:1", "b:3"}, .over = {"spin", "angle"}});
  CHECK_EQUAL(std::string(": a:2 b:1 b:4"), names(some.groups[0]));
  CHECK_EQUAL(2U, some.left_out.size());
  CHECK_EQUAL(std::string("b:3"), some.left_out[0]);
}

TEST(Selection, RefusesNamesThatNoShotOrSeveralHave) {
  CHECK_EQUAL(std::string("--without: no shot 7"), complaint({.without = {"7"}}));
  CHECK_EQUAL(std::string("--without: shot 1: several sessions have one: a:1, b:1"),
              complaint({.without = {"1"}}));
}

TEST(Selection, ReadsConditions) {
  CHECK_EQUAL(std::string("angle_deg"), parse_where("angle=23")->first);
  CHECK_EQUAL(std::string("a=b"), parse_where("remarks=a=b")->second);
  CHECK_FALSE(parse_where("spin").has_value());
  CHECK_FALSE(parse_where("=zero").has_value());
}

// Stored sessions as series take them.
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

Shot stored(std::uint32_t seed, const std::shared_ptr<const RigFile>& rig, const std::string& ball) {
  Scenario scenario;
  scenario.seed = seed;
  const SyntheticShot made = make_shot(scenario);
  Shot shot = measured_shot(made.shot, made.frame, {}, assembly_settings(*rig));
  shot.name = std::to_string(seed);
  shot.rig = rig;
  if (!ball.empty()) shot.readout.record["ball_name"] = ball;
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
  for (const Shot& shot : shots) {
    CHECK_FALSE(shot.rejected.has_value());
    CHECK_FALSE(shot.budget.sources.empty());
    // The lines are the readout's sds: to what a mixture's other assignments change.
    const double sd = std::hypot(*shot.readout.sd[Quantity::vx_td_mps],
                                 shot.readout.sd_systematic[Quantity::vx_td_mps].value_or(0.0));
    double combined = 0.0;
    for (const auto& source : shot.budget.sources)
      combined = std::hypot(combined, source.of(Quantity::vx_td_mps));
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
  session.shots[1].rejected = "the photograph did not come in time";
  session.shots[1].digitizations.clear();
  const auto shots = series_shots(session, "");
  CHECK_TRUE(shots[1].budget.sources.empty());
  const SeriesSummary summary = summarize("", shots);
  CHECK_EQUAL(2, summary.counted);
  CHECK_EQUAL(1, summary.rejected);
  CHECK_FALSE(matched_frame(session.shots[1]).has_value());
  CHECK_TRUE(matched_frame(session.shots[0])->images.size() > 5);
}
