#include "tests/soak/fault_plan.hpp"
#include "tests/soak/timeline.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::soak;

TEST_GROUP(Timeline){};

TEST(Timeline, GivesWhatHappensInOrderOfTimeAndAtOneInstantAsItWasScheduled) {
  Timeline<int> timeline;
  CHECK_EQUAL(kFarFuture, timeline.next());
  timeline.schedule(from_ns(20), 3);
  timeline.schedule(from_ns(10), 1);
  timeline.schedule(from_ns(20), 4);
  timeline.schedule(from_ns(10), 2);
  for (int expected = 1; expected <= 4; ++expected) {
    CHECK_EQUAL(from_ns(expected <= 2 ? 10 : 20), timeline.next());
    LONGS_EQUAL(expected, timeline.take().item);
  }
  CHECK_TRUE(timeline.empty());
}

TEST_GROUP(FaultPlan){};

TEST(FaultPlan, ReadsProbabilitiesByTheirNames) {
  const auto plan = read_fault_plan("flash_late = 0.5\nestop = 0.25\npacket_loss = 0.125\n", "faults.toml");
  CHECK_TRUE(plan.has_value());
  DOUBLES_EQUAL(0.5, plan->rig[static_cast<std::size_t>(sim::FaultKind::flash_late)], 0.0);
  DOUBLES_EQUAL(0.25, (*plan)[Hazard::estop], 0.0);
  DOUBLES_EQUAL(0.125, plan->packet_loss, 0.0);
  DOUBLES_EQUAL(0.0, (*plan)[Hazard::key_off], 0.0);
}

TEST(FaultPlan, NamesFileLineAndKeyOfWhatIsWrong) {
  const auto unknown = read_fault_plan("estop = 0.1\nflash_latte = 0.5\n", "faults.toml");
  CHECK_FALSE(unknown.has_value());
  STRCMP_CONTAINS("faults.toml:2: flash_latte", unknown.error().message.c_str());
  const auto large = read_fault_plan("estop = 1.5\n", "faults.toml");
  CHECK_FALSE(large.has_value());
  STRCMP_CONTAINS("faults.toml:1: estop", large.error().message.c_str());
  CHECK_FALSE(find_fault_plan("tame").has_value());
  CHECK((*find_fault_plan("stops"))[Hazard::page_disarm] > 0.0);
}

TEST(FaultPlan, StrikesWithTheStatedProbability) {
  FaultPlan plan;
  plan[sim::FaultKind::flash_dim] = 0.25;
  Random random(3);
  const auto faults = draw_rig_faults(plan, 4000, random);
  for (const auto& fault : faults) CHECK_EQUAL(sim::FaultKind::flash_dim, fault.kind);
  CHECK(faults.size() > 850 && faults.size() < 1150);  // 1000 with a sd of 27
  CHECK_TRUE(draw_rig_faults(no_faults(), 4000, random).empty());
}
