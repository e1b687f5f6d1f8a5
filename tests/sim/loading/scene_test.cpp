#include <map>
#include <string>

#include "sim/loading/load_scene.hpp"
#include "sim/scene/model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;

namespace {

const std::string kMin =
    "[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 0\n"
    "[bounce]\ncontact = \"grip\"\ne = 0.8\nmu = 0.6\nex = 0.1\noffset_mm = 2.5\ndwell_ms = 5\n";

std::string error_of(const std::string& text) {
  return testing::error_of(parse_scene(text, "scenes/some.toml"));
}

void refuses(const char* expected, const std::string& text) {
  STRCMP_CONTAINS(expected, error_of(text).c_str());
}

const std::string kOde =
    "title = \"ode\"\n[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 5\n"
    "[bounce]\ne = 0.8\nmu = 0.6\ndwell_ms = 5\nstiffness_ratio = 1.2\noffset_share = 0.1\n";
const std::string kGrip =
    "title = \"grip\"\n[machine]\nspeed_mps = 17\nangle_deg = -23\nspin_radps = 5\n"
    "[bounce]\ncontact = \"grip\"\ne = 0.8\nmu = 0.6\nex = 0.1\noffset_mm = 2.5\ndwell_ms = 5\n";

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
  CHECK_EQUAL("scenes/some.toml:13: lamps.dealy_us: unknown key; did you mean delay_us?", error_of(kMin + "[lamps]\ndealy_us = 3\n"));
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
  refuses("some.toml:13: air.lift_factor: must be", kMin + "[air]\nlift_factor = 4\n");
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

// What a scene takes from the one that it inherits from, and the error of each way of going wrong.

TEST_GROUP(SceneInheritance) {
  std::map<std::string, std::string> files{{"ode", kOde}, {"grip", kGrip}};

  Result<Scene> parse(const std::string& text) {
    return parse_scene(text, "child.toml", [this](const std::string& name, const std::string&) {
      const auto found = files.find(name);
      return found == files.end() ? Result<SceneText>(fail("no scene \"" + name + "\""))
                                  : Result<SceneText>(SceneText{found->second, name + ".toml"});
    });
  }

  Scene scene_of(const std::string& text) {
    const auto scene = parse(text);
    if (!scene) FAIL(scene.error().message.c_str());
    return *scene;
  }

  std::string error_of(const std::string& text) {
    const auto scene = parse(text);
    return scene ? "" : scene.error().message;
  }
  void refuses(const char* expected, const std::string& text) {
    STRCMP_CONTAINS(expected, error_of(text).c_str());
  }
};

TEST(SceneInheritance, TakesWhatTheChildDoesNotSay) {
  const Scene scene = scene_of("inherits = \"ode\"\n[machine]\nspeed_mps = 30\n[air]\ntemperature_c = 5\n");
  CHECK_EQUAL("child", scene.name);
  CHECK_EQUAL("ode", scene.parent);
  CHECK_EQUAL("ode", scene.title);
  DOUBLES_EQUAL(30.0, scene.machine.speed_mps, 0.0);
  DOUBLES_EQUAL(5.0, scene.machine.spin_radps, 0.0);
  DOUBLES_EQUAL(1.2, scene.bounce.stiffness_ratio, 0.0);
  DOUBLES_EQUAL(5.0, scene.air.temperature_c, 0.0);
}

TEST(SceneInheritance, GoesOverSeveralGenerations) {
  files["son"] = "inherits = \"ode\"\ntitle = \"son\"\n[bounce]\nmu = 0.4\ne = 0.7\n";
  const Scene scene = scene_of("inherits = \"son\"\n[bounce]\ne = 0.75\n");
  DOUBLES_EQUAL(0.75, scene.bounce.e, 0.0);
  DOUBLES_EQUAL(0.4, scene.bounce.mu, 0.0);
  DOUBLES_EQUAL(0.1, scene.bounce.offset_share, 0.0);
  CHECK_EQUAL("son", scene.title);
}

TEST(SceneInheritance, ReplacesArraysOfTablesAsAWhole) {
  files["faulty"] = kOde + "[[fault]]\nkind = \"ball_misses\"\n[[fault]]\nkind = \"machine_misfire\"\n";
  LONGS_EQUAL(2, scene_of("inherits = \"faulty\"\n").faults.size());
  const Scene scene = scene_of("inherits = \"faulty\"\n[[fault]]\nkind = \"no_photograph\"\n");
  LONGS_EQUAL(1, scene.faults.size());
  CHECK_EQUAL(FaultKind::no_photograph, scene.faults[0].kind);
  LONGS_EQUAL(0, scene_of("inherits = \"faulty\"\nfault = []\n").faults.size());
}

TEST(SceneInheritance, DropsTheParentsWayOfSayingAThingForTheChilds) {
  const Scene other_law =
      scene_of("inherits = \"ode\"\n[bounce]\ncontact = \"grip\"\nex = 0.2\noffset_mm = 1\n");
  CHECK_EQUAL(ContactLaw::grip, other_law.bounce.contact);
  DOUBLES_EQUAL(0.2, other_law.bounce.ex, 0.0);
  CHECK_EQUAL(ContactLaw::ode, scene_of("inherits = \"grip\"\n[bounce]\ncontact = \"ode\"\n").bounce.contact);

  files["springs"] = "inherits = \"ode\"\n[ball]\nstiffness_npm = 20000\ndamping_nspm = 2\n";
  const Scene springs = scene_of("inherits = \"springs\"\n");
  CHECK(springs.bounce.e > 0.8 && springs.bounce.e_slope_spm == 0.0);
  DOUBLES_EQUAL(0.7, scene_of("inherits = \"springs\"\n[bounce]\ne = 0.7\ndwell_ms = 4\n").bounce.e, 0.0);

  files["clay"] = "inherits = \"ode\"\n[surface]\nfriction = 0.7\n";
  DOUBLES_EQUAL(0.7, scene_of("inherits = \"clay\"\n").bounce.mu, 0.0);
  DOUBLES_EQUAL(0.5, scene_of("inherits = \"clay\"\n[bounce]\nmu = 0.5\n").bounce.mu, 0.0);

  files["solid"] = kOde + "[ball]\nalpha = 0.5\n";
  DOUBLES_EQUAL(0.4, scene_of("inherits = \"solid\"\n[ball]\ninertia = \"solid\"\n").ball.alpha, 0.0);
  files["tilted"] = "surface_angle_deg = 2\n" + kOde;
  DOUBLES_EQUAL(0.0, scene_of("inherits = \"tilted\"\n[surface]\ntilt_deg = 0\n").surface_angle_rad, 0.0);
}

TEST(SceneInheritance, KeepsAKeyOfTheWrongLawAnErrorWhereItIsWritten) {
  CHECK_EQUAL("child.toml:3: bounce.ex: belongs to contact = \"grip\", and this scene's is \"ode\"",
              error_of("inherits = \"ode\"\n[bounce]\nex = 0.1\n"));
  files["mixed"] = kGrip + "damping_ratio = 0.5\n";
  CHECK_EQUAL(
      "mixed.toml:13: bounce.damping_ratio: belongs to contact = \"ode\", and this scene's is \"grip\"",
      error_of("inherits = \"mixed\"\n"));
}

TEST(SceneInheritance, NamesTheFileAndLineInWhichTheKeyStands) {
  files["wrong"] = kOde + "[lamps]\ndealy_us = 3\n";
  CHECK_EQUAL("wrong.toml:13: lamps.dealy_us: unknown key; did you mean delay_us?", error_of("inherits = \"wrong\"\n"));
  files["wide"] = kOde + "[lamps]\ndelay_us = -3\n";
  refuses("wide.toml:13: lamps.delay_us: must be at least 0",
          "inherits = \"wide\"\n[lamps]\njitter_us = 1\n");
  refuses("child.toml:3: lamps.delay_us: must be at least 0",
          "inherits = \"wide\"\n[lamps]\ndelay_us = -3\n");
  files["broken"] = "[machine\n";
  refuses("broken.toml:1", "inherits = \"broken\"\n");
  files["partial"] = "[machine]\nspeed_mps = 17\n";
  refuses("machine.angle_deg: is missing", "inherits = \"partial\"\n");
}

TEST(SceneInheritance, RefusesAParentThatIsNotThere) {
  CHECK_EQUAL("child.toml:2: inherits: no scene \"nobody\"",
              error_of("title = \"x\"\ninherits = \"nobody\"\n"));
  refuses("child.toml:1: inherits: must be text", "inherits = 3\n");
  files["orphan"] = "\ninherits = \"nobody\"\n";
  CHECK_EQUAL("orphan.toml:2: inherits: no scene \"nobody\"", error_of("inherits = \"orphan\"\n"));
  const auto alone = parse_scene("inherits = \"ode\"\n", "child.toml");
  CHECK_EQUAL("child.toml:1: inherits: no other scenes can be read here", alone.error().message);
}

TEST(SceneInheritance, RefusesACycle) {
  files["a"] = "inherits = \"b\"\n";
  files["b"] = "\ninherits = \"a\"\n";
  CHECK_EQUAL("b.toml:2: inherits: a.toml inherits from itself", error_of("inherits = \"a\"\n"));
  files["child"] = "";
  CHECK_EQUAL("child.toml:1: inherits: child.toml inherits from itself", error_of("inherits = \"child\"\n"));
}

TEST(SceneInheritance, RefusesAChainThatIsTooLong) {
  const auto name = [](std::size_t i) { return std::string(1, 'p').append(std::to_string(i)); };
  const auto heir_of = [](const std::string& parent) {
    return std::string("inherits = \"").append(parent).append("\"\n");
  };
  const auto chain_of = [&](std::size_t parents) {
    files["p0"] = kOde;
    for (std::size_t i = 1; i < parents; ++i) files[name(i)] = heir_of(name(i - 1));
    return error_of(heir_of(name(parents - 1)));
  };
  CHECK_EQUAL("", chain_of(kMaxAncestors));
  CHECK_EQUAL("p1.toml:1: inherits: more than 16 scenes inherit from each other",
              chain_of(kMaxAncestors + 1));
}

TEST_GROUP(ModelText){};

TEST(ModelText, ReadsWhatToHave) {
  CHECK_EQUAL(Model::full(), *parse_model("full"));
  CHECK_EQUAL(Model::none(), *parse_model("none"));
  CHECK_EQUAL(Model::none().with(Effect::gravity).with(Effect::grip), *parse_model("gravity,grip"));
}

TEST(ModelText, ReadsWhatToLeaveOut) {
  const Model expected = Model::full().without(Effect::pixels).without(Effect::drag);
  CHECK_EQUAL(expected, *parse_model("-pixels,-drag"));
  CHECK_EQUAL(expected, *parse_model("-pixels,drag"));
  CHECK_EQUAL(expected, *parse_model("full-pixels-drag"));
}

TEST(ModelText, NamesTheWordThatIsNoEffect) {
  for (const char* text : {"gravity,pixel", "-pixel", "", "full-", "gravity,,drag"})
    CHECK_TEXT(!parse_model(text).has_value(), text);
  STRCMP_CONTAINS("\"pixel\" is no effect; there are gravity, drag",
                  parse_model("gravity,pixel").error().message.c_str());
}

TEST(ModelText, WritesWhatItReads) {
  for (const char* text : {"full", "none", "gravity,grip", "-drag,-pixels"})
    CHECK_EQUAL(text, model_text(*parse_model(text)));
}
