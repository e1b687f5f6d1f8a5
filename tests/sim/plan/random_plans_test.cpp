#include <array>
#include <cstdlib>
#include <string>

#include "sim/loading/parse_scene.hpp"
#include "tests/sim/plan/trial.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;

namespace {

/// STROBE_PLAN_SCENES from the environment, for a long run by hand (or strobe-bench plan), or what seconds
/// allow.
int scenes() {
  const char* text = std::getenv("STROBE_PLAN_SCENES");
  return text ? std::atoi(text) : strobe::testing::kSanitized ? 2 : 6;
}

}  // namespace

TEST_GROUP(RandomPlans){};

TEST(RandomPlans, DifferFromTheFullModelByNoMoreThanTheTolerance) {
  constexpr std::array kTolerances{1e-4, 1e-3, 1e-2, 5e-2};
  for (int number = 0; number < scenes(); ++number) {
    const test::RandomScene random = test::random_scene(static_cast<std::uint64_t>(number));
    const test::Trial trial = test::check_plans(random, kTolerances, 3, false);
    for (const test::Violation& v : trial.violations) {
      const std::string text = "scene " + std::to_string(number) + ", tolerance " +
                               std::to_string(v.tolerance) + ", " + std::string(reduction::name(v.quantity)) +
                               ":\n" + test::as_toml(random);
      FAIL(text.c_str());
    }
  }
}

// What a failure prints is a scene file that repeats it.
TEST(RandomPlans, AreWrittenAsSceneFilesThatCanBeRead) {
  for (std::uint64_t number = 0; number < 40; ++number) {
    const auto scene = parse_scene(test::as_toml(test::random_scene(number)), "random.toml");
    CHECK_TEXT(scene.has_value(), scene ? "" : scene.error().message.c_str());
  }
}
