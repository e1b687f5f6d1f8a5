#include <cmath>

#include "common/shot/plan_check.hpp"
#include "common/units/angles.hpp"
#include "host/design/train_search.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::host;
using reduction::Quantity;

const TrainWish kSpeeds{{Quantity::v_td_mps, Quantity::v_lo_mps, Quantity::e}, 0};

RigFile rig_with(Duration shortest_period) {
  RigFile rig;
  rig.camera.px_per_m = 4000.0;
  rig.camera.px_per_m_sd = 4.0;
  rig.camera.width_px = 2880;
  rig.camera.height_px = 1840;
  rig.limits.lamp_period = shortest_period;
  rig.limits.max_flashes = 400;
  rig.plan.even.period = milliseconds{3};
  rig.plan.even.exposure = milliseconds{120};
  rig.plan.even.impact_at = milliseconds{60};
  rig.plan.spacing = Spacing::even;
  return rig;
}

ExpectedBall ball() {
  ExpectedBall b;
  b.speed_mps = {17.0, 0.1};
  b.angle_rad = {radians(-23.0), 0.002};
  return b;
}

SetUp by_hand(const RigFile& rig) {
  SetUp s = *set_up_of(rig);
  s.measured_by = MeasuredBy::hand;
  s.fastest_spin_radps = 300.0;
  return s;
}

}  // namespace

TEST_GROUP(TrainSearch){};

TEST(TrainSearch, FlashesAsFastAsLampsAllowWhereImagesDoNotHinder) {
  const RigFile rig = rig_with(microseconds{1500});
  const SetUp s = by_hand(rig);
  const auto found = best_train(ball(), s, rig, rig.plan, kSpeeds);
  CHECK_TRUE(found.has_value());
  // Twice as many images: the root of 2 better, of what is not air or surface.
  CHECK(found->gain > 1.2 && found->gain < 1.6);
  CHECK_FALSE(plan_problem(found->plan.shot(), rig.limits).has_value());
  const auto again = read_plan(plan_to_toml(found->plan), "plan.toml", {});
  CHECK_TRUE(again.has_value());
  CHECK(again->shot() == found->plan.shot());
}

TEST(TrainSearch, KeepsAPlanThatNothingBetters) {
  const RigFile rig = rig_with(milliseconds{3});
  const auto found = best_train(ball(), by_hand(rig), rig, rig.plan, kSpeeds);
  CHECK_TRUE(found.has_value());
  CHECK(found->gain < 1.1);  // moved flashes may gain a little
  CHECK_FALSE(plan_problem(found->plan.shot(), rig.limits).has_value());
}

TEST(TrainSearch, KeepsToTheImagesThatAreAllowed) {
  const RigFile rig = rig_with(microseconds{1500});
  TrainWish few = kSpeeds;
  few.most_images = 5;
  const auto found = best_train(ball(), by_hand(rig), rig, rig.plan, few);
  CHECK_TRUE(found.has_value());
  CHECK(found->prediction.incoming[1] <= 6 && found->prediction.rebound[1] <= 6);  // one ball in many may show one more
}

TEST(TrainSearch, EndsWhenItIsToldTo) {
  const RigFile rig = rig_with(microseconds{1500});
  const auto found = best_train(ball(), by_hand(rig), rig, rig.plan, kSpeeds, [](double) { return false; });
  CHECK_TRUE(found.has_value());
  CHECK(found->tried < 10);
}
