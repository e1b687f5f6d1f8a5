#include "sim/loading/load_scene.hpp"

#include <string>

#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

const std::string kMin =
    "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
    "[bounce]\ncontact = \"grip\"\ne = 0.8\nmu = 0.6\nex = 0.1\noffset_mm = 2.5\ndwell_ms = 5\n";

std::string error_of(const std::string& text) {
  return testing::error_of(parse_scene(text, "scenes/some.toml"));
}

void refuses(const char* expected, const std::string& text) {
  STRCMP_CONTAINS(expected, error_of(text).c_str());
}

}  // namespace

TEST_GROUP(SceneFile){};

TEST(SceneFile, NeedsOnlyMachineAndBounce) {
  const auto scene = parse_scene(kMin, "scenes/some.toml");
  CHECK(scene.has_value());
  CHECK_EQUAL("some", scene->name);
  DOUBLES_EQUAL(0.0025, scene->bounce.offset_m, 1e-15);
  DOUBLES_EQUAL(0.310, scene->machine.lag_s, 1e-15);
  DOUBLES_EQUAL(12e-6, scene->lamps.delay_s, 1e-18);
  // e holds at the machine's mean unless said otherwise.
  DOUBLES_EQUAL(17.0 * 0.39073112848927377, scene->bounce.e_speed_mps, 1e-12);
}

TEST(SceneFile, RefusesAnUnknownKeyWithItsLine) {
  CHECK_EQUAL("scenes/some.toml:13: lamps.dealy_us: unknown key", error_of(kMin + "[lamps]\ndealy_us = 3\n"));
}

TEST(SceneFile, NamesWhatIsMissing) {
  refuses("machine.speed_mps: is missing", "[machine]\nangle_deg = -23\n");
}

TEST(SceneFile, RefusesAValueOutOfItsRange) {
  refuses("some.toml:13: lamps.delay_us: must be at least 0", kMin + "[lamps]\ndelay_us = -3\n");
}

TEST(SceneFile, ReadsTheAir) {
  const auto still = parse_scene(kMin, "some.toml");
  DOUBLES_EQUAL(0.55, still->air.drag_coefficient, 0.0);
  CHECK(still->air.lift && still->air.density_kgpm3 < 0.0);
  const auto thin = parse_scene(kMin +
                                    "[air]\ntemperature_c = 30\ndensity_kgpm3 = 0.9\ndrag_coefficient = 0\n"
                                    "lift_law = \"none\"\n",
                                "some.toml");
  DOUBLES_EQUAL(30.0, thin->air.temperature_c, 0.0);
  DOUBLES_EQUAL(0.9, thin->air.density_kgpm3, 0.0);
  CHECK(thin->air.drag_coefficient == 0.0 && !thin->air.lift);
}

TEST(SceneFile, RefusesAirThatCannotBe) {
  refuses("some.toml:13: air.drag_coefficient: must be at least 0",
          kMin + "[air]\ndrag_coefficient = -0.1\n");
  refuses("some.toml:13: air.density_kgpm3: must be at least 0", kMin + "[air]\ndensity_kgpm3 = -1\n");
  refuses("some.toml:13: air.lift_law: must be one of", kMin + "[air]\nlift_law = \"magnus\"\n");
}

TEST(SceneFile, RefusesWhatIsNoToml) { refuses("scenes/some.toml:1", "[machine\n"); }

TEST(SceneFile, ReadsWhatTheOperatorDoes) {
  const auto scene =
      parse_scene(kMin + "[[operator]]\nat_s = 1.5\nline = \"ESTOP\"\nlevel = 0\n", "some.toml");
  LONGS_EQUAL(1, scene->operator_actions.size());
  CHECK_EQUAL(RigLine::estop, scene->operator_actions[0].line);
}

TEST(SceneFile, LetsTheOperatorTouchInputsOnly) {
  refuses("operator[1].line: must be one of",
          kMin + "[[operator]]\nat_s = 1\nline = \"TRIGGER\"\nlevel = 1\n");
}

TEST(SceneFile, ReadsFaults) {
  const auto scene = parse_scene(kMin +
                                     "[[fault]]\nkind = \"flash_late\"\nshot = 2\nflash_from_impact = -2\n"
                                     "delay_us = 160\nlamp = \"b\"\n"
                                     "[[fault]]\nkind = \"frame_late\"\ndelay_s = 0.5\n",
                                 "some.toml");
  CHECK(scene.has_value());
  LONGS_EQUAL(2, scene->faults.size());
  const Fault& late = scene->faults[0];
  CHECK(late.kind == FaultKind::flash_late && late.shot == 2 && *late.flash_from_impact == -2);
  CHECK(late.delay == microseconds(160) && !late.lamp_a && late.lamp_b);
  CHECK(scene->faults[1].delay == milliseconds(500) && scene->faults[1].shot == 0);
}

TEST(SceneFile, RefusesAFaultThatCannotBe) {
  refuses("fault[1].kind: must be one of", kMin + "[[fault]]\nkind = \"flood\"\n");
  refuses("fault[1].kind: is missing", kMin + "[[fault]]\nshot = 1\n");
  refuses("fault[1].delay_us: is missing", kMin + "[[fault]]\nkind = \"flash_late\"\n");
  refuses("must not be 0", kMin + "[[fault]]\nkind = \"flash_missing\"\nflash_from_impact = 0\n");
  refuses("fault[1].lamp: unknown key", kMin + "[[fault]]\nkind = \"ball_misses\"\nlamp = \"a\"\n");
}
