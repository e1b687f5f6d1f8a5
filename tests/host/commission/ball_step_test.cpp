#include "host/commission/ball_step.hpp"

#include <vector>

#include "tests/host/commission/judged.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using commission_test::fails, commission_test::passes;

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

}  // namespace

TEST_GROUP(BallJudgement){};

TEST(BallJudgement, EachThrowMustBeOneBall) {
  auto shots = good_shots();
  passes(judge_throws(shots, true));
  shots[4].gate_edges = 2;
  fails("several_balls", judge_throws(shots, true));
  shots[4].gate_edges = 0;
  fails("gate_dead", judge_throws(shots, true));
  passes(judge_throws(shots, false));
  shots[4].images = 0;
  fails("no_ball", judge_throws(shots, true));
  shots[4].gate_edges = 1;
  fails("ball_unseen", judge_throws(shots, true));
}

TEST(BallJudgement, MostPhotographsMustTellTheirFlashes) {
  auto shots = good_shots();
  passes(judge_flashes(shots));
  for (std::size_t i = 0; i < 5; ++i) shots[i].rejected = "no surface";
  fails("flashes_unmatched", judge_flashes(shots));
  shots = good_shots();
  shots[2].readout.flashes->misassignment_probability = 0.2;
  fails("code_ambiguous", judge_flashes(shots));
  for (BallShot& shot : shots) shot.readout.flashes->coded = false;  // an even train names no flash
  passes(judge_flashes(shots));
}

TEST(BallJudgement, ResidualsMustBeAsStated) {
  auto shots = good_shots();
  passes(judge_noise(shots));
  for (BallShot& shot : shots) shot.readout.residual_ratios.by_kind[0] = 2.0;
  fails("noisy", judge_noise(shots));
  for (BallShot& shot : shots) shot.rejected = "none";
  CHECK_EQUAL("no_residuals", judge_noise(shots).fault);
}

TEST(BallJudgement, BallsMustComeWhenAndWhereTheyShould) {
  auto shots = good_shots();
  passes(judge_repeatability(shots, 0.310, 0.7));
  fails("machine_lag_off", judge_repeatability(shots, 0.330, 0.7));
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].spot_m = i % 2 == 0 ? 0.1 : 0.6;
  fails("machine_spread", judge_repeatability(shots, 0.310, 0.7));
  shots = good_shots();
  for (std::size_t i = 0; i < shots.size(); ++i) shots[i].lag_s = i % 2 == 0 ? 0.23 : 0.39;
  CHECK_EQUAL("lag_spread", judge_repeatability(shots, 0.310, 0.7).fault);
}
