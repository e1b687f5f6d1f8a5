// Plans against a rig's limits: what is refused, and which field of a plan file it is. The firmware's own tests go
// through the limits one by one (tests/firmware/pulse_schedule_test.cpp).
#include "common/shot/plan_check.hpp"

#include <string>

#include "tests/support/string_from.hpp"

using namespace strobe;

TEST_GROUP(PlanCheck) {
  PlanLimits limits;
  ShotPlan plan{.period = milliseconds(3), .exposure = milliseconds(500), .impact_at = milliseconds(250)};

  void setup() override {
    limits.lamp_period = microseconds(1500);
    limits.lamp_pulse = microseconds(50);
    limits.flash_interval = microseconds(400);
    limits.max_flashes = 400;
    limits.longest_exposure = milliseconds(2000);
  }
  std::string field() const {
    const auto problem = plan_problem(plan, limits);
    return problem ? problem->field : "";
  }
};

TEST(PlanCheck, NamesTheFieldThatExceedsALimit) {
  CHECK_EQUAL("", field());
  plan.period = microseconds(1499);
  CHECK_EQUAL("period_us", field());
  plan.period = microseconds(1500);
  plan.exposure = microseconds(1500 * 400 + 1);
  CHECK_EQUAL("period_us", field());  // 401 flashes
  plan.period = milliseconds(10);
  plan.exposure = milliseconds(2000) + Duration{1};
  CHECK_EQUAL("shutter_open_ms", field());
  plan.exposure = plan.impact_at;
  CHECK_EQUAL("impact_at_ms", field());
}

TEST(PlanCheck, NamesTheFieldsOfAGatedTrain) {
  plan.train = Train::gated;
  CHECK_EQUAL("flash_count", field());
  plan.flash_count = 5;
  CHECK_EQUAL("", field());
  plan.gate_delay = plan.exposure;
  CHECK_EQUAL("gate_delay_ms", field());
  limits.gate_fitted = false;
  CHECK_EQUAL("train", field());
}

TEST(PlanCheck, NamesTheFlashOfACodeThatComesTooSoon) {
  plan.code = {{milliseconds(0), Lamps::both}, {milliseconds(3), Lamps::a}, {microseconds(4400), Lamps::a}};
  CHECK_EQUAL("intervals_us", field());
  STRCMP_CONTAINS("flash 2 of the coded train comes 1400 us after lamp A's one before",
                  plan_problem(plan, limits)->what.c_str());
}

TEST(PlanCheck, TakesTheRigFilesImpactWhereThePlanHasNone) {
  plan.impact_at = {};
  CHECK_EQUAL("", field());
  limits.impact_at = milliseconds(500);
  CHECK_EQUAL("impact_at_ms", field());
}

TEST(PlanCheck, WithoutLimitsRefusesOnlyWhatNoRigCanPlay) {
  limits = {};
  plan.period = microseconds(130);
  CHECK_EQUAL("", field());
  plan.period = Duration{};
  CHECK_EQUAL("period_us", field());
  plan.period = -milliseconds(1);
  CHECK_EQUAL("period_us", field());
}
