#include "sim/plan/plan.hpp"

#include <cmath>

#include "sim/loading/scene_files.hpp"
#include "sim/motion/shot_conditions.hpp"
#include "sim/plan/choose.hpp"
#include "sim/plan/corners.hpp"
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
    // Nothing more could go: each effect that is kept would by itself take the sum beyond.
    for (const PlannedEffect& e : p.effects) {
      if (!e.needed) continue;
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
}

TEST(Plan, NeedsLittleForAGreatToleranceAndNearlyEverythingForNone) {
  SceneBounds bounds(top_23());
  const Plan exact = plan(bounds, 1e-7);
  const Plan rough = plan(bounds, 0.05);
  CHECK_TRUE(fewer_or_same(rough.model, exact.model));
  for (const Effect effect : {Effect::gravity, Effect::drag, Effect::magnus, Effect::tangential_compliance})
    CHECK_TRUE(exact.model.has(effect));
  CHECK_FALSE(rough.model.has(Effect::spin_decay));
  CHECK_TRUE(rough.model.has(Effect::grip));
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
  // What only spins or the rebound feel may go; the drag before the impact may not.
  CHECK_FALSE(p.model.has(Effect::spin_decay));
  CHECK_FALSE(p.model.has(Effect::tangential_compliance));
  CHECK_TRUE(p.model.has(Effect::drag));
}

TEST(Plan, KeepsAllThatDisplacesImagesWhereFaultsDecideWhichThereAre) {
  Scene scene = top_23();
  scene.faults.push_back({.kind = FaultKind::flash_missing, .flash_index = 3});
  SceneBounds bounds(scene);
  const Plan p = plan(bounds, 0.05);
  CHECK_FALSE(p.warning.empty());
  for (const PlannedEffect& e : p.effects) CHECK_EQUAL(!e.bound.all_zero(), e.needed);
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
