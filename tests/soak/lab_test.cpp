// Whole shots in the virtual lab: some thousand of them in each test run. The long run is tests/soak/run.
#include "tests/soak/lab.hpp"

#include <algorithm>
#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::soak;

TEST_GROUP(VirtualLab) {
  RigFiles files = *read_rig_files(STROBE_SHIPPED_RIG);
  std::string violations;

  SoakCounts run_lab(const FaultPlan& faults, PlanKind plan, int runs, int shots = 10,
                     std::uint64_t seed = 2026) {
    SoakCounts sum;
    for (int run = 0; run < runs; ++run) {
      RunSettings settings;
      settings.seed = seed;
      settings.run = run;
      settings.shots = shots;
      settings.faults = faults;
      settings.plan = plan;
      Lab lab(files, settings);
      sum.add(lab.run());
      for (const std::string& violation : lab.invariant_checker().violations())
        violations += "\nseed " + std::to_string(seed) + ", run " + std::to_string(run) + ": " + violation;
    }
    CHECK_EQUAL("", violations);
    return sum;
  }
  template <std::size_t N>
  bool all_occurred(const std::array<std::int64_t, N>& counts) const {
    return std::ranges::all_of(counts, [](std::int64_t count) { return count > 0; });
  }
};

TEST(VirtualLab, ReadsEveryShotOutWhenNothingGoesWrong) {
  const SoakCounts counts = run_lab(no_faults(), PlanKind::brief, 60);
  LONGS_EQUAL(600, counts.good);
  LONGS_EQUAL(counts.shots, counts.triggers);
  LONGS_EQUAL(0, counts.unfinished);
  // Two chance errors of a hundred thousand are beyond 4.3 sd.
  for (const double z : counts.largest_z) CHECK(z > 1.0 && z < 6.0);
}

TEST(VirtualLab, PlaysTheShippedPlanAndBurstsAfterTheGate) {
  LONGS_EQUAL(60, run_lab(no_faults(), PlanKind::shipped, 6).good);
  LONGS_EQUAL(100, run_lab(no_faults(), PlanKind::gated, 10).good);
  LONGS_EQUAL(100, run_lab(no_faults(), PlanKind::coded, 10).good);
}

TEST(VirtualLab, HoldsWhatMustHoldThroughEveryKindOfFault) {
  const SoakCounts counts = run_lab(wild_faults(), PlanKind::brief, 60);
  CHECK_TRUE(all_occurred(counts.rig_faults));
  CHECK_TRUE(all_occurred(counts.hazards));
  CHECK(counts.packets_lost > 0 && counts.packets_doubled > 0 && counts.packets_reordered > 0);
  CHECK(counts.events_journalled > 10'000);
  LONGS_EQUAL(0, counts.events_missing);
}

// On a network that delays and doubles, but loses nothing; what a lost DISARM and a firmware that starts anew can do
// is for the long run (`--faults stops`).
TEST(VirtualLab, FiresNothingBetweenAStopAndTheNextActOfAPerson) {
  FaultPlan plan = stop_faults();
  plan.packet_loss = plan[Hazard::network_outage] = 0.0;
  plan[Hazard::firmware_kill] = plan[Hazard::firmware_stop] = 0.0;
  const SoakCounts counts = run_lab(plan, PlanKind::brief, 20);
  CHECK(counts.stops_reached > 200);  // compilers' last digits lead to some 420 or 300
  CHECK(counts.acts > counts.stops_reached / 2);
  CHECK(counts.triggers > 100);
  CHECK(counts.stops_asked > 80);
  CHECK(counts.stops_confirmed > counts.stops_asked / 2);
  LONGS_EQUAL(0, counts.stopped_triggers);
}

TEST(VirtualLab, IsTheSameToTheLastBitWhateverStrangersSend) {
  FaultPlan plan;
  const SoakCounts alone = run_lab(plan, PlanKind::brief, 20);
  plan.strangers = 1.0;
  const SoakCounts attacked = run_lab(plan, PlanKind::brief, 20);
  CHECK(attacked.strangers > 10'000);
  CHECK_EQUAL(alone.digest, attacked.digest);
  LONGS_EQUAL(200, attacked.triggers);
}

TEST(VirtualLab, ThrowsTheBallsAskedForWhileALogOfAnotherDayIsPlayedBack) {
  FaultPlan plan;
  plan.played_back = 0.5;
  const SoakCounts counts = run_lab(plan, PlanKind::brief, 20);
  CHECK(counts.strangers > 5'000);
  LONGS_EQUAL(200, counts.good);
  LONGS_EQUAL(200, counts.triggers);
}

TEST(VirtualLab, IsRightOrSaysThatItIsNotAtTheExtremes) {
  const SoakCounts counts = run_lab(no_faults(), PlanKind::extremes, 40);
  CHECK(counts.compared > 1'000);
}

TEST(VirtualLab, RepeatsItselfToTheLastBitFromItsSeed) {
  const std::uint64_t digest = run_lab(wild_faults(), PlanKind::mixed, 4, 5).digest;
  CHECK_EQUAL(run_lab(wild_faults(), PlanKind::mixed, 4, 5).digest, digest);
  CHECK(digest != run_lab(wild_faults(), PlanKind::mixed, 4, 5, 2027).digest);
}
