// What each effect does to a frame, where a short argument says what it must do.
#include <cmath>
#include <numbers>

#include "sim/shoot/shoot.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;

constexpr double kScale_pxpm = 4000.0;

Scene still_scene() {
  Scene scene;
  scene.name = "still";
  scene.machine.speed_sd_mps = scene.machine.lag_sd_s = scene.machine.spot_sd_m = 0.0;
  scene.machine.angle_rad = -0.4;
  scene.machine.spin_radps = 200.0;
  scene.bounce.e_speed_mps = 6.6;
  scene.camera.roll_rad = 0.0;
  scene.lamps.jitter_s = scene.sensors.jitter_s = scene.shutter.lag_sd_s = 0.0;
  return scene;
}

reduction::Frame frame_of(const Scene& scene, const Model& model = Model::full()) {
  const auto shot = shoot(scene, 3, 1, model, {.perfect_digitizer = true});
  CHECK(shot.has_value() && shot->flags.none());
  return shot->frame;
}

/// Of the images before the impact: how the centre moves on average between two of them. [px]
struct Steps {
  double x = 0.0, y = 0.0;
};
Steps steps(const reduction::Frame& frame) {
  int n = 0;
  while (*frame.images[static_cast<std::size_t>(n + 1)].leg == reduction::Leg::incoming) ++n;
  const auto& a = frame.images.front().centre_px;
  const auto& b = frame.images[static_cast<std::size_t>(n)].centre_px;
  return {(b.x - a.x) / n, (b.y - a.y) / n};
}

}  // namespace

TEST_GROUP(ShootEffects) { Scene scene = still_scene(); };

TEST(ShootEffects, AirAndWeightBendAStraightLine) {
  const Model bare = Model::none().with(Effect::grip);
  const auto& straight = frame_of(scene, bare).images;
  // Four incoming images in a line, evenly spaced, turning evenly.
  for (std::size_t i = 1; i + 1 < 4; ++i) {
    DOUBLES_EQUAL(
        0.0, straight[i - 1].centre_px.x - 2.0 * straight[i].centre_px.x + straight[i + 1].centre_px.x, 1e-9);
    DOUBLES_EQUAL(
        0.0, straight[i - 1].centre_px.y - 2.0 * straight[i].centre_px.y + straight[i + 1].centre_px.y, 1e-9);
    DOUBLES_EQUAL(200.0 * 3e-3,
                  std::remainder(*straight[i + 1].equator_rad - *straight[i].equator_rad, std::numbers::pi),
                  1e-9);
  }
  const auto& falling = frame_of(scene, bare.with(Effect::gravity)).images;
  DOUBLES_EQUAL(-9.80665 * 9e-6 * kScale_pxpm,
                falling[0].centre_px.y - 2.0 * falling[1].centre_px.y + falling[2].centre_px.y, 1e-9);
  const auto& slowed = frame_of(scene, bare.with(Effect::drag)).images;
  // 13 m/s² along the path (C_D .55): 15.7 m/s² · cos .4.
  const double drag = 1.2 * std::numbers::pi * 0.0651 * 0.0651 / 4.0 * 0.55 / (2.0 * 0.0576) * 17.0 * 17.0;
  DOUBLES_EQUAL(-drag * std::cos(0.4) * 9e-6 * kScale_pxpm,
                slowed[0].centre_px.x - 2.0 * slowed[1].centre_px.x + slowed[2].centre_px.x, 0.03);
  const auto& fading = frame_of(scene, bare.with(Effect::spin_decay)).images;
  const double first = std::remainder(*fading[1].equator_rad - *fading[0].equator_rad, std::numbers::pi);
  const double next = std::remainder(*fading[2].equator_rad - *fading[1].equator_rad, std::numbers::pi);
  DOUBLES_EQUAL(0.01 * 17.0 * 3e-3, 1.0 - next / first, 1e-6);
}

TEST(ShootEffects, AFlashOnlyShiftsTheImagesByHalfItsWay) {
  scene.lamps.flash_s = 50e-6;
  const auto& lit = frame_of(scene).images;
  const auto& instant = frame_of(scene, Model::full().without(Effect::flash_duration)).images;
  LONGS_EQUAL(instant.size(), lit.size());
  for (std::size_t i = 0; i < 4; ++i) {
    // 25 µs of 15.66 m/s, more by what drag has still to take: 13 m/s² in 20 ms.
    DOUBLES_EQUAL(25e-6 * 15.66 * kScale_pxpm, lit[i].centre_px.x - instant[i].centre_px.x,
                  25e-6 * 0.3 * kScale_pxpm);
    DOUBLES_EQUAL(25e-6 * 200.0, *lit[i].equator_rad - *instant[i].equator_rad, 1e-4);
    DOUBLES_EQUAL(instant[i].time_s, lit[i].time_s, 0.0);
  }
}

TEST(ShootEffects, DelaysOfLampsAndSensorsChangeNoInterval) {
  scene.lamps.delay_s = 30e-6;
  scene.sensors.delay_s = 5e-6;
  const auto& late = frame_of(scene).images;
  const auto& prompt =
      frame_of(scene, Model::full().without(Effect::lamp_delay).without(Effect::sensor_delay)).images;
  for (std::size_t i = 0; i < prompt.size(); ++i) {
    DOUBLES_EQUAL(prompt[i].time_s, late[i].time_s, 1e-15);
    if (i < 4) DOUBLES_EQUAL(30e-6 * 15.66 * kScale_pxpm, late[i].centre_px.x - prompt[i].centre_px.x, 0.05);
  }
}

TEST(ShootEffects, TheShutterDecidesNothingInThisTrain) {
  scene.shutter.lag_sd_s = 2e-3;
  const auto& with = frame_of(scene).images;
  const auto& without = frame_of(scene, Model::full().without(Effect::shutter_lag)).images;
  LONGS_EQUAL(with.size(), without.size());
  for (std::size_t i = 0; i < with.size(); ++i)
    DOUBLES_EQUAL(with[i].centre_px.x, without[i].centre_px.x, 0.0);
}

TEST(ShootEffects, ABallNearerToTheLensLooksLargerAndFaster) {
  scene.camera.distance_m = 1.5;
  scene.camera.off_plane_sd_m = 0.03;
  const auto shot = shoot(scene, 3, 1, Model::full(), {.perfect_digitizer = true});
  const double off_plane = shot->exposure.ball->path.off_plane_m();
  CHECK(std::abs(off_plane) > 1e-3);
  const double nearer = 1.5 / (1.5 - off_plane);
  const reduction::Frame flat = frame_of(scene, Model::full().without(Effect::perspective));
  DOUBLES_EQUAL(0.0651 * kScale_pxpm, flat.images[0].diameter_px, 1e-9);
  // But for the square of the angles under which ball and view are seen, .02² and .2².
  DOUBLES_EQUAL(nearer, shot->frame.images[0].diameter_px / flat.images[0].diameter_px, 0.02);
  DOUBLES_EQUAL(nearer, steps(shot->frame).x / steps(flat).x, 1e-3);
  DOUBLES_EQUAL(nearer, steps(shot->frame).y / steps(flat).y, 1e-3);
}

TEST(ShootEffects, TheLensEnlargesWhatIsFarFromItsAxis) {
  scene.camera.distortion = 0.05;
  const auto& bent = frame_of(scene).images;
  const auto& straight = frame_of(scene, Model::full().without(Effect::lens_distortion)).images;
  const double x = straight[0].centre_px.x - 1500.0;
  const double y = straight[0].centre_px.y - 300.0 - 0.175 * kScale_pxpm;
  const double share = 0.05 * (x * x + y * y) / (kScale_pxpm * kScale_pxpm * (0.09 + 0.175 * 0.175));
  DOUBLES_EQUAL(x * share, bent[0].centre_px.x - straight[0].centre_px.x, 0.05 * std::abs(x * share));
  DOUBLES_EQUAL(y * share, bent[0].centre_px.y - straight[0].centre_px.y, 0.05 * std::abs(y * share));
}

TEST(ShootEffects, PixelsChangeAnImageByHundredthsOfAPixel) {
  scene.camera.pixels = true;
  const auto& drawn = frame_of(scene).images;
  const auto& exact = frame_of(scene, Model::full().without(Effect::pixels)).images;
  double most = 0.0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double dx = drawn[i].centre_px.x - exact[i].centre_px.x;
    const double dy = drawn[i].centre_px.y - exact[i].centre_px.y;
    most = std::max(most, std::hypot(dx, dy));
    DOUBLES_EQUAL(exact[i].diameter_px, drawn[i].diameter_px, 0.01);
    DOUBLES_EQUAL(0.0, std::remainder(*drawn[i].equator_rad - *exact[i].equator_rad, std::numbers::pi), 1e-3);
  }
  CHECK(most > 0.0 && most < 0.01);
}

TEST(ShootEffects, TheTabletsErrorsAreThoseOfTheSceneAndNoneWhenPerfect) {
  scene.tablet.centre_sd_m = 0.5e-3;
  const auto perfect = shoot(scene, 3, 1, Model::full(), {.perfect_digitizer = true});
  const auto real = shoot(scene, 3, 1);
  DOUBLES_EQUAL(2.0, *perfect->frame.centre_sd_px, 1e-12);
  DOUBLES_EQUAL(2.0, *real->frame.centre_sd_px, 1e-12);
  double square = 0.0;
  for (std::size_t i = 0; i < perfect->frame.images.size(); ++i) {
    const double error = real->frame.images[i].centre_px.x - perfect->frame.images[i].centre_px.x;
    square += error * error / static_cast<double>(perfect->frame.images.size());
  }
  CHECK(std::sqrt(square) > 0.8 && std::sqrt(square) < 4.0);  // of a dozen draws with sd 2
}
