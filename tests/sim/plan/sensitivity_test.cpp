#include "sim/plan/sensitivity.hpp"

#include <random>

#include "sim/plan/nominal_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

namespace {

reduction::Frame frame_of(bool mirrored) {
  Scene scene;
  scene.camera.mirrored = mirrored;
  scene.camera.roll_rad = 0.02;
  scene.bounce.e_speed_mps = 6.6;
  const ModelledScene modelled(scene, Model::full());
  const auto shot = NominalShot::make(modelled, {});
  CHECK_TRUE(shot.has_value());
  const Train train{0.003, 0.05, 0.05};
  return shot->photograph(shot->flashes(train, 0.4, 0.0)).frame;
}

constexpr CoordinateMask kAll{true, true, true, true, true};

}  // namespace

TEST_GROUP(Sensitivity){};

TEST(Sensitivity, KnowsWhatTheSameSpeedMoreForAllImagesDoes) {
  // All images drawn out along the surface by 1 % of 17 m/s.
  for (const bool mirrored : {false, true}) {
    const reduction::Frame frame = frame_of(mirrored);
    const Sensitivity sensitivity(frame, mirrored, kAll);
    std::vector<BoundedDisplacement> displaced(frame.images.size());
    for (std::size_t i = 0; i < displaced.size(); ++i) displaced[i].by.x_m = 0.17 * frame.images[i].time_s;
    const PerQuantity change = sensitivity.propagated(displaced);
    // To first order: .17 m/s but for the tilt, which these images do not touch.
    DOUBLES_EQUAL(0.17, change[Quantity::vx_td_mps], 2e-3);
    DOUBLES_EQUAL(0.17, change[Quantity::vx_lo_mps], 2e-3);
    DOUBLES_EQUAL(0.0, change[Quantity::vy_td_mps], 2e-3);
  }
}

TEST(Sensitivity, BoundsWhatRandomDisplacementsDo) {
  const reduction::Frame frame = frame_of(false);
  const Sensitivity sensitivity(frame, false, kAll);
  std::vector<BoundedDisplacement> displaced(frame.images.size());
  // On the scale of the sensitivity's own steps: smaller ones, so that second order is below a percent.
  for (BoundedDisplacement& d : displaced) d.within = {2e-5, 2e-5, 2e-5, 1e-4, 1e-6};
  const PerQuantity bound = sensitivity.propagated(displaced);
  std::mt19937_64 random(1);
  const auto draw = [&](double size) {
    return size * (2.0 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1.0);
  };
  const double scale = frame.images[0].diameter_px / frame.ball_diameter_m;
  for (int k = 0; k < 200; ++k) {
    reduction::Frame moved = frame;
    for (reduction::BallImage& image : moved.images) {
      // Within the square whatever the roll: its diagonal is sqrt(2) of the side.
      image.centre_px.x += draw(2e-5 / std::numbers::sqrt2 * scale);
      image.centre_px.y += draw(2e-5 / std::numbers::sqrt2 * scale);
      image.diameter_px += draw(2e-5 * scale);
      *image.equator_rad += draw(1e-4);
      image.time_s += draw(1e-6);
    }
    const PerQuantity change = difference(readout_of(moved), sensitivity.readout());
    for (std::size_t q = 0; q < reduction::kQuantityCount; ++q) CHECK_TRUE(change[q] <= 1.01 * bound[q]);
  }
}

TEST(Sensitivity, MovesNothingForContactImages) {
  const reduction::Frame frame = frame_of(false);
  const Sensitivity sensitivity(frame, false, kAll);
  std::vector<BoundedDisplacement> displaced(frame.images.size());
  bool any = false;
  for (std::size_t i = 0; i < displaced.size(); ++i) {
    if (frame.images[i].leg != reduction::Leg::contact) continue;
    any = true;
    displaced[i].within.x_m = 1.0;
  }
  CHECK_TRUE(any);
  CHECK_TRUE(sensitivity.propagated(displaced).all_zero());
}
