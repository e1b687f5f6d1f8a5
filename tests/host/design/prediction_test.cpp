#include <cmath>
#include <numeric>

#include "common/flight/gravity.hpp"
#include "common/units/angles.hpp"
#include "host/design/expected_ball.hpp"
#include "host/design/prediction.hpp"
#include "host/design/needs.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host;
using reduction::Quantity;

constexpr double kScale_pxpm = 4000.0, kNoise_m = 0.0001;

/// In air that does nothing, of no spin and no spread.
ExpectedBall steady_ball() {
  ExpectedBall b;
  b.speed_mps = {17.0, 0.0};
  b.angle_rad = {radians(-23.0), 0.0};
  b.air_density_kgpm3 = 1e-9;
  return b;
}

/// A person measures; scale, stamps and arrival are exact.
SetUp exact_set_up() {
  SetUp s;
  s.px_per_m = kScale_pxpm;
  s.camera.px_per_m = kScale_pxpm;
  s.camera.px_per_m_sd = 0.0;
  s.width_px = 6000.0;
  s.height_px = 3000.0;
  s.touchdown_x_px = 3000.0;
  s.surface_y_px = 300.0;
  s.spot_sd_m = 0.0;
  s.measured_by = MeasuredBy::hand;
  s.hand_centre_sd_m = kNoise_m;
  s.flash_time_sd_s = 1e-12;
  s.arrival_sd_s = 0.0;
  s.fastest_spin_radps = 300.0;
  return s;
}

/// Of these instants before touchdown, and as many after a contact.
ExpectedTrain train_of(std::vector<double> before_s) {
  ExpectedTrain train;
  for (const double t : before_s) train.flash_s.push_back(-t);
  for (auto t = before_s.rbegin(); t != before_s.rend(); ++t) train.flash_s.push_back(0.007 + *t);
  const double first = train.flash_s.front();
  for (double& t : train.flash_s) t -= first;
  train.touchdown_s = -first;
  return train;
}

std::vector<double> even(int count, double from_s, double step_s) {
  std::vector<double> instants;
  for (int i = count; i-- > 0;) instants.push_back(from_s + i * step_s);
  return instants;
}

/// Of a straight line's slope through points with that noise, least squares.
double slope_sd(const std::vector<double>& times_s, double noise_m) {
  const double mean = std::accumulate(times_s.begin(), times_s.end(), 0.0) / static_cast<double>(times_s.size());
  double squares = 0.0;
  for (const double t : times_s) squares += (t - mean) * (t - mean);
  return noise_m / std::sqrt(squares);
}

double vx_sd(const std::vector<double>& before_s) {
  const auto p = predict(steady_ball(), exact_set_up(), train_of(before_s), {.balls = 4, .budgets = 0, .match = false});
  CHECK_TRUE(p.has_value());
  LONGS_EQUAL(4, p->readable);
  return p->of(Quantity::vx_td_mps)->shot_sd;
}

}  // namespace

TEST_GROUP(ExpectedBall){};

TEST(ExpectedBall, DrawsStandForANormalDistribution) {
  // Moments to rounding; of two numbers that are independent, quasi-random draws are off by some (ln n)²/n.
  constexpr std::size_t kCount = 1024;
  double sum = 0.0, squares = 0.0, product = 0.0;
  for (const BallDraw& d : ball_draws(kCount)) {
    sum += d.speed;
    squares += d.speed * d.speed;
    product += d.speed * d.arrival;
  }
  DOUBLES_EQUAL(0.0, sum / kCount, 1e-12);
  DOUBLES_EQUAL(1.0, squares / kCount, 1e-12);
  DOUBLES_EQUAL(0.0, product / kCount, 0.03);
}

TEST(ExpectedBall, FallsFreelyWithoutAir) {
  const ExpectedBall ball = steady_ball();
  const auto course = BallCourse::make(ball, {}, {0.0, -flight::kStandardGravity_mps2});
  CHECK_TRUE(course.has_value());
  constexpr double kBefore_s = 0.02;
  const double vx = 17.0 * std::cos(radians(23.0)), vy = -17.0 * std::sin(radians(23.0));
  const auto place = course->at(-kBefore_s);
  // Rounding, and air of a billionth of the usual density.
  DOUBLES_EQUAL(-kBefore_s * vx, place.centre_m.x(), 1e-9);
  DOUBLES_EQUAL(ball.ball.radius_m() - kBefore_s * vy - 0.5 * flight::kStandardGravity_mps2 * kBefore_s * kBefore_s,
                place.centre_m.y(), 1e-9);
  CHECK_TRUE(course->at(0.5 * course->dwell_s()).in_contact);
  DOUBLES_EQUAL(-0.75 * vy, course->lift_off().vy_mps, 0.02);
}

TEST(ExpectedBall, SaysWhatIsWrongWithOne) {
  ExpectedBall ball;
  CHECK_FALSE(problem_of(ball).has_value());
  ball.angle_rad.mean = radians(10.0);
  STRCMP_CONTAINS("angle", problem_of(ball)->c_str());
  ball = {};
  ball.e.mean = 1.5;
  STRCMP_CONTAINS("e: must be", problem_of(ball)->c_str());
  ball = {};
  ball.mu.sd = -1.0;
  STRCMP_CONTAINS("spread", problem_of(ball)->c_str());
}

TEST_GROUP(Prediction){};

TEST(Prediction, OfASlopeIsThatOfAStraightLine) {
  // Gravity and scale are known: what is left of vx is a straight line's slope. Both legs share the surface's tilt,
  // which moves vx by the square of a small angle only.
  for (const int images : {3, 5, 9}) {
    const std::vector<double> times = even(images, 0.002, 0.0025);
    DOUBLES_EQUAL(1.0, vx_sd(times) / slope_sd(times, kNoise_m), 0.03);
  }
}

TEST(Prediction, ImagesAtBothEndsOfALegTellItsSlopeBetter) {
  // Theory: the root of 3 (N - 1)/(N + 1) for half of N images at each end; near the ends, not at them, a little less.
  constexpr int kImages = 6;
  const double span_s = 0.018;
  const std::vector<double> spread = even(kImages, 0.002, span_s / (kImages - 1));
  std::vector<double> ends;
  for (const double t : {1.0, 0.98, 0.96, 0.04, 0.02, 0.0}) ends.push_back(0.002 + t * span_s);
  const double gained = vx_sd(spread) / vx_sd(ends);
  DOUBLES_EQUAL(slope_sd(spread, kNoise_m) / slope_sd(ends, kNoise_m), gained, 0.03);
  DOUBLES_EQUAL(std::sqrt(3.0 * (kImages - 1) / (kImages + 1)), gained, 0.08);
}

TEST(Prediction, IsNoneWhereTheDigitizerIsNotKnown) {
  SetUp s = exact_set_up();
  s.measured_by = MeasuredBy::digitizer;
  s.px_per_m = 300.0;  // a ball of 20 px
  const auto p = predict(steady_ball(), s, train_of(even(6, 0.002, 0.0025)), {.balls = 4});
  CHECK_TRUE(p.has_value());
  LONGS_EQUAL(0, p->readable);
  LONGS_EQUAL(1, p->reasons.size());
  STRCMP_CONTAINS("not known for balls of 20 px", p->reasons.begin()->first.c_str());
  CHECK_FALSE(p->of(Quantity::e).has_value());
}

TEST(Prediction, WithholdsASpinThatEvenFlashesDoNotTell) {
  // Half a turn in 28 ms is 112 rad/s: 424 looks like 88, or -24. In 3 ms it turns by 1.27, less than half of pi.
  ExpectedBall ball = steady_ball();
  ball.speed_mps.mean = 3.3;
  ball.spin_radps.mean = -424.0;
  SetUp s = exact_set_up();
  s.fastest_spin_radps = 600.0;
  const auto slow = predict(ball, s, train_of(even(5, 0.002, 0.028)), {.balls = 8, .budgets = 0, .match = false});
  CHECK_TRUE(slow.has_value());
  CHECK_FALSE(slow->spins_known());
  CHECK_FALSE(slow->of(Quantity::omega_td_radps).has_value());
  CHECK_TRUE(slow->of(Quantity::vy_td_mps).has_value());
  const auto fast = predict(ball, s, train_of(even(20, 0.002, 0.003)), {.balls = 8, .budgets = 0, .match = false});
  CHECK_TRUE(fast->spins_known());
  DOUBLES_EQUAL(-424.0, fast->of(Quantity::omega_td_radps)->mean, 1.0);
}

TEST(Prediction, OfAMeanHasASharedPartThatStays) {
  PredictedQuantity q;
  q.spread = 3.0;
  q.shot_sd = 5.0;
  q.shared_sd = 4.0;  // so that single shots scatter by the root of 9 + 25 - 16
  DOUBLES_EQUAL(std::sqrt(18.0 / 9.0 + 16.0), q.mean_sd(9), 1e-12);
  CHECK(q.expanded(9) > 1.96 * q.mean_sd(9));
  DOUBLES_EQUAL(1.96 * 4.0, q.expanded(1000000), 0.01);
}

TEST(Prediction, WhatTheDigitizersDiametersAreOffAlikeStaysInAMean) {
  SetUp s = exact_set_up();
  s.camera.px_per_m_sd.reset();  // the diameters tell the scale
  const auto shared = [&](MeasuredBy by) {
    s.measured_by = by;
    const auto p = predict(steady_ball(), s, train_of(even(6, 0.002, 0.0025)), {.balls = 4, .match = false});
    CHECK_TRUE(p.has_value());
    LONGS_EQUAL(4, p->readable);
    return p->of(Quantity::v_td_mps)->shared_sd / p->of(Quantity::v_td_mps)->mean;
  };
  // Some hundredths of a px of a ball of hundreds; the ball itself is exact, and so is what a person reads.
  const double by_digitizer = shared(MeasuredBy::digitizer);
  CHECK_TRUE(by_digitizer > 3e-5 && by_digitizer < 5e-4);
  CHECK_TRUE(shared(MeasuredBy::hand) < 1e-6);
}

TEST(Prediction, CountsTheShotsThatAreNeeded) {
  Prediction p;
  PredictedQuantity q;
  q.mean = 0.8;
  q.spread = 0.01;
  q.shot_sd = 0.002;
  q.shared_sd = 0.001;
  p.quantities[static_cast<std::size_t>(Quantity::e)] = q;
  const std::vector<Wanted> wanted{{Quantity::e, 0.005, false}, {Quantity::e, 0.0019, false}, {Quantity::mu, 1.0, false}};
  const std::vector<Wanted> differences{{Quantity::e, 1.0, true}};
  const auto list = needs(p, wanted, differences, 0.9);
  LONGS_EQUAL(3, list.size());  // nothing is foretold of mu
  // n = (t s / U)^2 with t of 18 degrees of freedom 2.1: some 19.
  CHECK(list[0].shots && *list[0].shots >= 17 && *list[0].shots <= 21);
  CHECK_FALSE(list[1].shots.has_value());  // 1.96 times what is shared is more
  DOUBLES_EQUAL(0.008, list[2].half_width, 1e-12);
  CHECK(list[2].is_difference && list[2].shots);
}
