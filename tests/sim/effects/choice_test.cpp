#include "sim/effects/choice.hpp"

#include <cmath>
#include <cstdlib>

#include "sim/effects/unmodelled.hpp"
#include "sim/loading/load_scene.hpp"
#include "sim/random/draws.hpp"
#include "tests/sim/effects/trial.hpp"
#include "tests/support/repetitions.hpp"

#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

namespace {

Scene top_23() {
  const auto scene = load_scene(STROBE_SCENES_FOLDER "/top_23.toml");
  CHECK_TRUE(scene.has_value());
  return *scene;
}

}  // namespace

TEST_GROUP(ModelChoice) {
  const Scene scene = top_23();
  ModelChooser chooser{scene};
};

TEST(ModelChoice, IsTheSameEveryTime) {
  const ModelChoice a = chooser.choose(0.01);
  const ModelChoice b = ModelChooser(scene).choose(0.01);
  CHECK_EQUAL(b.model, a.model);
  CHECK_EQUAL(*b.changed, *a.changed);
}

TEST(ModelChoice, KeepsWhatCostsNothingHoweverCoarseTheTolerance) {
  const ModelChoice choice = chooser.choose(0.5);
  for (std::size_t i = 0; i < kEffectCount; ++i) {
    const auto effect = static_cast<Effect>(i);
    CHECK_EQUAL(!is_decided(effect) && chooser.present().has(effect), choice.model.has(effect));
  }
}

TEST(ModelChoice, SolvesTheContactNoFinerThanSampledShotsDemand) {
  double before = kFullContactTolerance;
  for (const double tolerance : {1e-9, 1e-6, 1e-4, 1e-2}) {
    const ModelChoice choice = chooser.choose(tolerance);
    CHECK(choice.model.contact_tolerance() >= before);
    before = choice.model.contact_tolerance();
    CHECK(!choice.changed || within(*choice.changed, choice.allowed));
  }
  DOUBLES_EQUAL(1e-3, before, 0.0);
  const ModelChoice exact = chooser.choose(1e-12);
  CHECK_EQUAL(kFullContactTolerance, exact.model.contact_tolerance());
  CHECK_EQUAL(chooser.present(), exact.model);
}

// Other shots than the sampled ones, by a seed that no choice knows.
TEST(ModelChoice, HoldsForShotsThatWereNotSampled) {
  const ModelChoice choice = chooser.choose(1e-3);
  const ShootSettings perfect{.perfect_digitizer = true};
  auto full = Shooter::make(scene, 99, Model::full(), perfect);
  auto chosen = Shooter::make(scene, 99, choice.model, perfect);
  for (int shot = 1; shot <= 300; ++shot)
    CHECK(within(difference(readout_of(chosen->shoot(shot).frame), readout_of(full->shoot(shot).frame)),
                 choice.tolerances));
}

// A share p of bad shots passes 500 draws with (1 - p)^500, one of six candidates with at most six times that.
TEST(ModelChoice, StatesAShareThatItsSampleSupports) {
  const double p = sampled_share();
  DOUBLES_EQUAL(1.0 - kConfidence, kCandidates * std::pow(1.0 - p, kSampledShots), 1e-12);
  CHECK(p < 0.01);
}

TEST(ModelChoice, LeavesOutWhatTheSceneHasNot) {
  Scene less = scene;
  less.air.drag_coefficient = 0.0;
  const ModelChoice choice = ModelChooser(less).choose(1e-7);
  for (const Effect effect : {Effect::drag, Effect::perspective, Effect::lens_distortion, Effect::pixels})
    CHECK_FALSE(choice.model.has(effect));
  CHECK(choice.model.has(Effect::contact_ode));
}

TEST(ModelChoice, LeavesOutPixelsWhereTheyChangeLittle) {
  Scene rendered = scene;
  rendered.camera.pixels = true;
  rendered.camera.px_per_m = 1000.0;
  ModelChooser of_pixels(rendered);
  CHECK(of_pixels.choose(1e-7).model.has(Effect::pixels));
  CHECK_FALSE(of_pixels.choose(0.1).model.has(Effect::pixels));
}

TEST(ModelChoice, TakesTheScenesOwnTolerances) {
  Scene own = scene;
  own.readout.absolute = {{Quantity::vx_td_mps, 0.02}};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    if (static_cast<Quantity>(i) != Quantity::vx_td_mps)
      own.readout.absolute.emplace_back(static_cast<Quantity>(i), -1.0);
  const ModelChoice choice = ModelChooser(own).choose(1e-9);
  DOUBLES_EQUAL(0.02, choice.tolerances[Quantity::vx_td_mps], 0.0);
  CHECK_TRUE(std::isinf(choice.tolerances[Quantity::mu]));
  // What only the rebound feels may be as coarse as it likes.
  CHECK_FALSE(choice.model.has(Effect::flash_duration));
  DOUBLES_EQUAL(1e-3, choice.model.contact_tolerance(), 0.0);
}

TEST(ModelChoice, KnowsAScalesMeaning) {
  const PerQuantity t = tolerances(scene, 0.01);
  DOUBLES_EQUAL(0.01 * scene.machine.speed_mps, t[Quantity::slip_lo_mps], 1e-15);
  DOUBLES_EQUAL(0.01 * scene.machine.speed_mps / scene.ball.radius_m(), t[Quantity::omega_td_radps], 1e-12);
  DOUBLES_EQUAL(0.01, t[Quantity::e], 0.0);
  DOUBLES_EQUAL(1.0, t[Quantity::court_pace], 1e-15);
}

// Without the weight in flight, dwell and angles change by percents; the shutter's lag changes nothing.
TEST(ModelChoice, MeasuresWhatEachEffectChanges) {
  const PerQuantity gravity = chooser.change_by(Effect::gravity);
  const PerQuantity scale = readout_scales(scene);
  CHECK(gravity[Quantity::dwell_time_ms] > 0.01 * scale[Quantity::dwell_time_ms]);
  CHECK(gravity[Quantity::dwell_time_ms] < 0.2 * scale[Quantity::dwell_time_ms]);
  CHECK(chooser.change_by(Effect::shutter_lag).all_zero());
}

TEST(ModelChoice, TellsWhatWasLeftOut) {
  const std::string text = explanation(chooser.choose(0.01), scene);
  STRCMP_CONTAINS("for 1%, left out: contact_ode, flash_duration; the contact is solved to 1e-03", text.c_str());
  STRCMP_CONTAINS("with 95% confidence fewer than 0.95% of shots", text.c_str());
  STRCMP_CONTAINS("no effect is left out", explanation(chooser.choose(1e-12), scene).c_str());
}

// STROBE_EFFECTS_SCENES from the environment, for a long run by hand (or strobe-bench effects), or what seconds allow.
TEST(ModelChoice, KeepsTheToleranceInRandomScenes) {
  const char* asked = std::getenv("STROBE_EFFECTS_SCENES");
  const int scenes = asked ? std::atoi(asked) : strobe::testing::kSanitized ? 2 : 6;
  constexpr std::array kTolerances{1e-4, 1e-3, 1e-2, 5e-2};
  for (int number = 0; number < scenes; ++number) {
    const test::RandomScene random = test::random_scene(static_cast<std::uint64_t>(number));
    for (const test::Violation& v : test::check_choices(random, kTolerances, 3).violations) {
      const std::string text = "scene " + std::to_string(number) + ", tolerance " +
                               std::to_string(v.tolerance) + ", " + std::string(reduction::name(v.quantity)) +
                               ":\n" + test::as_toml(random);
      FAIL(text.c_str());
    }
  }
}

// What a failure prints is a scene file that repeats it.
TEST(ModelChoice, OfARandomSceneCanBeRepeatedFromItsFile) {
  for (std::uint64_t number = 0; number < 40; ++number) {
    const auto read = parse_scene(test::as_toml(test::random_scene(number)), "random.toml");
    CHECK_TEXT(read.has_value(), read ? "" : read.error().message.c_str());
  }
}

TEST(ModelChoice, KnowsWhatNoModelHas) {
  Scene inclined = scene;
  // q·C_D·v²·T with the scene's fastest ball, by hand from its file: 4 sds of .295 m/s over 17.54, of .26 ms over 5.06.
  const auto of = [&](std::string_view name) {
    for (const UnmodelledTerm& term : unmodelled_terms(inclined))
      if (term.name == name) return term.bound;
    return 0.0;
  };
  const double v = scene.machine.speed_mps + kLargestNormal * scene.machine.speed_sd_mps;
  const double t = scene.bounce.dwell_s + kLargestNormal * scene.bounce.dwell_sd_s;
  const double density = 101325.0 / (287.05 * 294.15), r = scene.ball.radius_m();
  const double drag = density * 3.14159265 * r * r / (2.0 * scene.ball.mass_kg) * 0.55 * v * v * t;
  DOUBLES_EQUAL(drag, of("drag_in_contact"), 1e-3 * drag);
  CHECK_EQUAL(0.0, of("weight_along_plate"));
  inclined.bounce.contact = ContactLaw::grip;
  inclined.surface_angle_rad = 0.1;
  DOUBLES_EQUAL(9.80665 * std::sin(0.1) * t, of("weight_along_plate"), 1e-12);
  inclined.air.density_kgpm3 = 0.0;
  UNSIGNED_LONGS_EQUAL(3, unmodelled_terms(inclined).size());  // spin decay, the earth's rotation, the weight
}
