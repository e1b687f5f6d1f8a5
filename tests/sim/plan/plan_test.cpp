#include "sim/plan/plan.hpp"

#include <cmath>

#include "sim/loading/scene_files.hpp"
#include "sim/motion/shot_conditions.hpp"
#include "sim/plan/choose.hpp"
#include "sim/plan/corners.hpp"
#include "sim/plan/unmodelled.hpp"
#include "sim/random/draws.hpp"

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

bool fewer_or_same(const Model& a, const Model& b) {
  for (std::size_t i = 0; i < kEffectCount; ++i)
    if (a.has(static_cast<Effect>(i)) && !b.has(static_cast<Effect>(i))) return false;
  return true;
}

bool same(double a, double b) { return a == b || std::abs(a - b) <= 1e-12 * std::abs(b); }

}  // namespace

TEST_GROUP(Plan){};

TEST(Plan, LeavesOutNoMoreThanTheToleranceAllowsAltogether) {
  SceneBounds bounds(top_23());
  for (const double tolerance : {1e-4, 1e-3, 1e-2, 5e-2}) {
    const Plan p = plan(bounds, tolerance);
    for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) CHECK_TRUE(p.left_out[q] <= p.tolerance[q]);
    // Nothing more could go: each decided effect that is kept would by itself take the sum beyond.
    for (const PlannedEffect& e : p.effects) {
      if (!e.needed || !is_decided(e.effect)) continue;
      const PerQuantity more = bounds.of(p.model.without(e.effect));
      bool beyond = false;
      for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) beyond = beyond || more[q] > p.tolerance[q];
      CHECK_TRUE(beyond);
    }
  }
}

TEST(Plan, IsTheSameEveryTime) {
  const Scene scene = top_23();
  SceneBounds first(scene);
  SceneBounds second(scene);
  const Plan a = plan(first, 0.01);
  const Plan b = plan(second, 0.01);
  CHECK_EQUAL(b.model, a.model);
  CHECK_EQUAL(b.left_out, a.left_out);
  CHECK_EQUAL(b.sampled->largest, a.sampled->largest);
}

TEST(Plan, KeepsWhatCostsNothingHoweverCoarseTheTolerance) {
  SceneBounds bounds(top_23());
  for (const PlannedEffect& e : plan(bounds, 0.5).effects)
    if (!is_decided(e.effect)) CHECK_EQUAL(e.present, e.needed);
}

TEST(Plan, SolvesTheContactNoFinerThanSampledShotsDemand) {
  SceneBounds bounds(top_23());
  double before = kFullContactTolerance;
  for (const double tolerance : {1e-9, 1e-6, 1e-4, 1e-2}) {
    const Plan p = plan(bounds, tolerance);
    CHECK(p.model.contact_tolerance() >= before);
    before = p.model.contact_tolerance();
    if (!p.sampled) continue;
    for (std::size_t q = 0; q < reduction::kQuantityCount; ++q)
      CHECK(p.sampled->largest[q] <= kSampledPart * p.tolerance[q]);
  }
  DOUBLES_EQUAL(1e-3, before, 0.0);
  CHECK_EQUAL(kFullContactTolerance, plan(bounds, 1e-12).model.contact_tolerance());
}

// Other shots than the sampled ones, by a seed that no plan knows.
TEST(Plan, ShotsThatWereNotSampledKeepTheToleranceToo) {
  const Scene scene = top_23();
  SceneBounds bounds(scene);
  const Plan p = plan(bounds, 1e-3);
  const ShootSettings perfect{.perfect_digitizer = true};
  auto full = Shooter::make(scene, 99, Model::full(), perfect);
  auto planned = Shooter::make(scene, 99, p.model, perfect);
  for (int shot = 1; shot <= 300; ++shot) {
    const PerQuantity change =
        difference(readout_of(planned->shoot(shot).frame), readout_of(full->shoot(shot).frame));
    for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) CHECK(change[q] <= p.tolerance[q]);
  }
}

// A share p of bad shots passes 500 draws with (1 - p)^500, one of six candidates with at most six times that.
TEST(Plan, StatesAShareThatItsSampleSupports) {
  const double p = sampled_share();
  DOUBLES_EQUAL(1.0 - kConfidence, kCandidates * std::pow(1.0 - p, kSampledShots), 1e-12);
  CHECK(p < 0.01);
}

TEST(Plan, BoundsWhatNoModelHas) {
  Scene scene = top_23();
  // q·C_D·v²·T with the scene's fastest ball, by hand from its file: 4 sds of .295 m/s over 17.54, of .26 ms over 5.06.
  const auto terms = unmodelled_terms(scene);
  const auto of = [&](std::string_view name) {
    for (const UnmodelledTerm& term : unmodelled_terms(scene))
      if (term.name == name) return term.bound;
    return 0.0;
  };
  const double v = scene.machine.speed_mps + kLargestNormal * scene.machine.speed_sd_mps;
  const double t = scene.bounce.dwell_s + kLargestNormal * scene.bounce.dwell_sd_s;
  const double density = 101325.0 / (287.05 * 294.15), r = scene.ball.radius_m();
  const double drag = density * 3.14159265 * r * r / (2.0 * scene.ball.mass_kg) * 0.55 * v * v * t;
  DOUBLES_EQUAL(drag, of("drag_in_contact"), 1e-3 * drag);
  CHECK_EQUAL(0.0, of("weight_along_plate"));
  scene.bounce.contact = ContactLaw::grip;
  scene.surface_angle_rad = 0.1;
  DOUBLES_EQUAL(9.80665 * std::sin(0.1) * t, of("weight_along_plate"), 1e-12);
  scene.air.density_kgpm3 = 0.0;
  UNSIGNED_LONGS_EQUAL(3, unmodelled_terms(scene).size());  // spin decay, the earth's rotation, the weight
}

TEST(Plan, NeedsLittleForAGreatToleranceAndNearlyEverythingForNone) {
  SceneBounds bounds(top_23());
  const Plan exact = plan(bounds, 1e-7);
  const Plan rough = plan(bounds, 0.05);
  CHECK_TRUE(fewer_or_same(rough.model, exact.model));
  CHECK_TRUE(exact.model.has(Effect::contact_ode));
  CHECK_FALSE(rough.model.has(Effect::contact_ode));
}

TEST(Plan, LeavesOutAtOnceWhatTheSceneHasNot) {
  Scene scene = top_23();
  scene.air.drag_coefficient = 0.0;
  SceneBounds bounds(scene);
  const Plan p = plan(bounds, 1e-7);
  for (const Effect effect : {Effect::drag, Effect::perspective, Effect::lens_distortion, Effect::pixels}) {
    CHECK_FALSE(p.model.has(effect));
    CHECK_FALSE(p.effects[static_cast<std::size_t>(effect)].present);
  }
}

TEST(Plan, TakesTheScenesOwnTolerances) {
  Scene scene = top_23();
  scene.readout.absolute = {{Quantity::vx_td_mps, 0.02}};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i)
    if (static_cast<Quantity>(i) != Quantity::vx_td_mps)
      scene.readout.absolute.emplace_back(static_cast<Quantity>(i), -1.0);
  SceneBounds bounds(scene);
  const Plan p = plan(bounds, 1e-9);
  DOUBLES_EQUAL(0.02, p.tolerance[Quantity::vx_td_mps], 0.0);
  CHECK_TRUE(std::isinf(p.tolerance[Quantity::mu]));
  // What only the rebound feels may be as coarse as it likes.
  CHECK_FALSE(p.model.has(Effect::flash_duration));
  DOUBLES_EQUAL(1e-3, p.model.contact_tolerance(), 0.0);
}

TEST(Plan, KeepsAllThatDisplacesImagesWhereFaultsDecideWhichThereAre) {
  Scene scene = top_23();
  scene.faults.push_back({.kind = FaultKind::flash_missing, .flash_index = 3});
  SceneBounds bounds(scene);
  const Plan p = plan(bounds, 0.05);
  CHECK_FALSE(p.warning.empty());
  for (const PlannedEffect& e : p.effects) CHECK_EQUAL(e.present, e.needed);
}

TEST(Plan, KnowsAScalesMeaning) {
  const Scene scene = top_23();
  const PerQuantity t = tolerances(scene, 0.01);
  DOUBLES_EQUAL(0.01 * scene.machine.speed_mps, t[Quantity::slip_lo_mps], 1e-15);
  DOUBLES_EQUAL(0.01 * scene.machine.speed_mps / scene.ball.radius_m(), t[Quantity::omega_td_radps], 1e-12);
  DOUBLES_EQUAL(0.01, t[Quantity::e], 0.0);
  DOUBLES_EQUAL(1.0, t[Quantity::court_pace], 1e-15);
}

TEST(Plan, WithADeadlineThatNothingMeetsNamesTheNearest) {
  const Scene scene = top_23();
  // No shot takes a nanosecond, whatever the machine.
  const auto refused = choose(scene, {.tolerance = 1e-4, .deadline_us = 1e-3}, {});
  CHECK_FALSE(refused.has_value());
  CHECK_EQUAL(0, refused.error().message.find("--deadline-us"));
  CHECK_TRUE(refused.error().message.find("the fastest takes") != std::string::npos);
  const auto ample = choose(scene, {.tolerance = {}, .deadline_us = 1e9}, {});
  CHECK_TRUE(ample.has_value());
  DOUBLES_EQUAL(kLadder.front(), ample->tolerance, 0.0);
}

TEST_GROUP(Corners){};

TEST(Corners, AreWithinTheDrawsAndBeginWithTheMean) {
  const std::vector<Corner> all = corners(top_23());
  for (const double z : all.front().z) DOUBLES_EQUAL(0.0, z, 0.0);
  for (const Corner& corner : all)
    for (const double z : corner.z) CHECK_TRUE(std::abs(z) <= kLargestNormal);
}

TEST(Corners, OfASceneWithoutSpreadAreItsMean) {
  const Scene scene = without_spread(top_23());
  UNSIGNED_LONGS_EQUAL(1, corners(scene).size());
  UNSIGNED_LONGS_EQUAL(0, inside(scene, 10).size());
}

TEST(Corners, OfTwoSpreadsHaveAllFourCombinations) {
  Scene scene = without_spread(top_23());
  scene.machine.speed_sd_mps = 0.1;
  scene.bounce.e_sd = 0.01;
  int combinations = 0;
  for (const Corner& c : corners(scene))
    if (c[Spread::speed] != 0.0 && c[Spread::e] != 0.0) ++combinations;
  LONGS_EQUAL(4, combinations);
}

TEST(Corners, EncloseTheShotsThatAreDrawn) {
  Scene scene = top_23();
  scene.machine.speed_sd_mps = 0.5;
  Corner fast;
  fast.z[static_cast<std::size_t>(Spread::speed)] = kLargestNormal;
  const ShotConditions fastest = shot_conditions_at(scene, fast);
  DOUBLES_EQUAL(scene.machine.speed_mps + kLargestNormal * 0.5,
                std::hypot(fastest.touchdown.vx_mps, fastest.touchdown.vy_mps), 1e-9);
  const ShotConditions mean = shot_conditions_at(scene, {});
  CHECK_TRUE(same(scene.machine.spin_radps, mean.touchdown.omega_radps));
}
