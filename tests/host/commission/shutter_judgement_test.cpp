// What the shutter's contact says of its lag.
#include "host/commission/electrical/shutter_judgement.hpp"

#include <vector>

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::commission;
using strobe_msgs::shot_t;

std::vector<shot_t> shots(double opens_ms, double closes_ms, std::int8_t feedback = shot_t::FEEDBACK_SEEN) {
  std::vector<shot_t> made;
  for (int k = 0; k < 5; ++k) {
    const double spread_ms = 0.1 * (k - 2);
    shot_t shot{};
    shot.shutter_feedback = feedback;
    shot.shutter_on_ns = 1'000'000'000LL * (k + 1);
    shot.shutter_off_ns = shot.shutter_on_ns + 150'000'000;
    shot.shutter_open_ns = shot.shutter_on_ns + static_cast<std::int64_t>(1e6 * (opens_ms + spread_ms));
    shot.shutter_close_ns = shot.shutter_off_ns + static_cast<std::int64_t>(1e6 * (closes_ms + spread_ms));
    made.push_back(shot);
  }
  return made;
}

}  // namespace

TEST_GROUP(ShutterJudgement) {
  host::RigFile rig = *host::read_rig("rig = \"bench\"\n[shutter]\nlag_ms = 45\n", "rig.toml");
};

TEST(ShutterJudgement, MeasuresTheLagOfAGoodShutter) {
  const StepResult result = judge_shutter("shutter", shots(45.5, 44.0), rig);
  CHECK_TRUE_TEXT(result.state == StepState::passed, result.words.c_str());
  DOUBLES_EQUAL(45.5, *result.value, 1e-6);
  DOUBLES_EQUAL(0.1 * std::sqrt(2.5 / 5.0), *result.sd, 1e-6);
}

TEST(ShutterJudgement, NamesAShutterThatIsLateEarlyOrStuck) {
  CHECK_EQUAL("shutter_late", judge_shutter("shutter", shots(53.0, 45.0), rig).fault);
  CHECK_EQUAL("shutter_late", judge_shutter("shutter", shots(45.0, 53.0), rig).fault);
  CHECK_EQUAL("shutter_early", judge_shutter("shutter", shots(30.0, 45.0), rig).fault);
  CHECK_EQUAL("shutter_late", judge_shutter("shutter", shots(90.0, 90.0, shot_t::FEEDBACK_LATE), rig).fault);
  CHECK_EQUAL("shutter_stuck",
              judge_shutter("shutter", shots(45.0, 45.0, shot_t::FEEDBACK_MISSING), rig).fault);
}

TEST(ShutterJudgement, IsLeftOutWithoutAContact) {
  CHECK_TRUE(judge_shutter("shutter", shots(45.0, 45.0, shot_t::FEEDBACK_NONE), rig).state ==
             StepState::skipped);
}
