#include "common/messages/plan_lcm.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;

TEST_GROUP(PlanMessage){};

TEST(PlanMessage, CarriesAPlanThereAndBack) {
  ShotPlan plan;
  plan.train = Train::gated;
  plan.period = microseconds(1777);
  plan.flash_count = 12;
  plan.exposure = milliseconds(321);
  plan.gate_delay = microseconds(4001);
  plan.impact_at = milliseconds(99);
  plan.dry = true;
  CHECK(messages::plan_from_lcm(messages::plan_to_lcm(plan)) == plan);
}

TEST(PlanMessage, CarriesACodedTrainThereAndBack) {
  ShotPlan plan;
  for (int k = 0; k < 300; ++k)
    plan.code.push_back({microseconds(3000 * k + 7 * k * k), k % 3 == 0   ? Lamps::a
                                                             : k % 3 == 1 ? Lamps::b
                                                                          : Lamps::both});
  CHECK(messages::plan_from_lcm(messages::plan_to_lcm(plan)) == plan);
}
