#include "host/commission/balls/ball_judgement.hpp"

#include <vector>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;

constexpr double kLocal_mps2 = 9.81;

FreeFall fall(double g_mps2, double sd_mps2 = 0.01) {
  FreeFall found;
  found.g_mps2 = g_mps2;
  found.g_sd_mps2 = sd_mps2;
  found.inclination_sd_rad = 1e-3;
  found.degrees_of_freedom = 40;
  found.chi_squared = 40.0;
  found.legs = 6;
  found.images = 40;
  return found;
}

std::vector<BallShot> good_shots(int count = 9) {
  std::vector<BallShot> shots;
  for (int i = 0; i < count; ++i) {
    BallShot shot;
    shot.readout.value[reduction::Quantity::v_td_mps] = 17.0 + 0.02 * (i % 3);
    shot.readout.residual_ratios.by_kind[0] = 1.0 + 0.02 * (i % 5 - 2);
    shot.readout.flashes = reduction::ImagedFlashes{60, 80, 1e-6, true};
    shot.images = 20;
    shot.centres = 40;
    shot.lag_s = 0.310 + 0.002 * (i % 3 - 1);
    shot.spot_m = 0.4 + 0.005 * (i % 3 - 1);
    shot.gate_edges = 1;
    shots.push_back(shot);
  }
  return shots;
}

void passes(const StepResult& result) { CHECK_TEXT(result.state == StepState::passed, result.words.c_str()); }
void fails(const char* fault, const StepResult& result) {
  CHECK_TEXT(result.state == StepState::failed, result.words.c_str());
  CHECK_EQUAL(fault, result.fault);
  CHECK(!result.advice.empty());
  CHECK(result.value.has_value());
}

}  // namespace

TEST_GROUP(BallJudgement){};

TEST(BallJudgement, GravityMustBeThePlacesWithinHalfAPercent) {
  passes(judge_gravity("gravity", fall(9.82), kLocal_mps2, 5e-4));
  fails("gravity_off", judge_gravity("gravity", fall(9.81 / 1.01), kLocal_mps2, 5e-4));
  fails("gravity_off", judge_gravity("gravity", fall(9.81 * 1.01), kLocal_mps2, 5e-4));
  // What is not known well enough is no pass.
  fails("gravity_uncertain", judge_gravity("gravity", fall(9.81, 0.05), kLocal_mps2, 5e-4));
}

TEST(BallJudgement, ThePlateMustBeInclinedAsStated) {
  FreeFall inclined = fall(9.81);
  inclined.inclination_rad = 0.0523;
  passes(judge_inclination("inclination", inclined, 3.0));
  fails("plate_inclined", judge_inclination("inclination", inclined, 0.0));
}

TEST(BallJudgement, TheBallsSizeMustFitScaleAndDiameter) {
  ScaleCheck check{1.002, 1e-4, 0.0, 1e-4, 0.0, 1e-4, 180, 9};
  passes(judge_scale("scale", check, 0.0015, 5e-4));
  check.ratio = 1.01;
  fails("scale_off", judge_scale("scale", check, 0.0015, 5e-4));
  passes(judge_scale("scale", check, 0.003, 5e-4));  // a diameter known to .3 % cannot tell
}

TEST(BallJudgement, TheBallsSizeMustNotChangeOverThePhotograph) {
  ScaleCheck check{1.0, 1e-4, 0.004, 1e-4, -0.004, 1e-4, 180, 9};
  passes(judge_squareness("square", check));
  check.upwards = 0.007;
  fails("camera_tilted", judge_squareness("square", check));
}

TEST(BallJudgement, EachThrowMustBeOneBall) {
  auto shots = good_shots();
  passes(judge_throws("throws", shots, true));
  shots[4].gate_edges = 2;
  fails("several_balls", judge_throws("throws", shots, true));
  shots[4].gate_edges = 0;
  fails("gate_dead", judge_throws("throws", shots, true));
  passes(judge_throws("throws", shots, false));
  shots[4].images = 0;
  fails("no_ball", judge_throws("throws", shots, true));
  shots[4].gate_edges = 1;
  fails("ball_unseen", judge_throws("throws", shots, true));
}

TEST(BallJudgement, MostPhotographsMustTellTheirFlashes) {
  auto shots = good_shots();
  passes(judge_flashes("flashes", shots));
  for (std::size_t i = 0; i < 5; ++i) shots[i].rejected = "no surface";
  fails("flashes_unmatched", judge_flashes("flashes", shots));
  shots = good_shots();
  shots[2].readout.flashes->misassignment_probability = 0.2;
  fails("code_ambiguous", judge_flashes("flashes", shots));
  for (BallShot& shot : shots) shot.readout.flashes->coded = false;  // an even train names no flash
  passes(judge_flashes("flashes", shots));
}

TEST(BallJudgement, ResidualsMustBeAsStated) {
  auto shots = good_shots();
  passes(judge_noise("noise", shots));
  for (BallShot& shot : shots) shot.readout.residual_ratios.by_kind[0] = 2.0;
  fails("noisy", judge_noise("noise", shots));
  for (BallShot& shot : shots) shot.rejected = "none";
  CHECK_EQUAL("no_residuals", judge_noise("noise", shots).fault);
}

TEST(BallJudgement, BallsMustComeWhenAndWhereTheyShould) {
  auto shots = good_shots();
  passes(judge_repeatability("repeatability", shots, 0.310, 0.7));
  fails("machine_lag_off", judge_repeatability("repeatability", shots, 0.330, 0.7));
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].spot_m = i % 2 == 0 ? 0.1 : 0.6;
  fails("machine_spread", judge_repeatability("repeatability", shots, 0.310, 0.7));
  shots = good_shots();
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].lag_s = i % 2 == 0 ? 0.23 : 0.39;
  CHECK_EQUAL("lag_spread", judge_repeatability("repeatability", shots, 0.310, 0.7).fault);
}
