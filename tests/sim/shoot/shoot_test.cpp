#include <atomic>
#include <string>
#include <thread>

#include "common/messages/json_conversions.hpp"
#include "common/reduction/reduce.hpp"
#include "sim/rig/truth.hpp"
#include "sim/shoot/shoot.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

namespace {

Scene scene_of_a_bounce() {
  Scene scene;
  scene.name = "bounce";
  scene.machine.angle_rad = -23.0 * std::numbers::pi / 180.0;
  scene.machine.speed_sd_mps = 0.2;
  scene.machine.spin_sd_radps = 5.0;
  scene.bounce.e_speed_mps = 17.0 * 0.39;
  scene.bounce.mu_sd = 0.02;
  return scene;
}

bool same(const reduction::Frame& a, const reduction::Frame& b) {
  if (a.images.size() != b.images.size()) return false;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    const auto& p = a.images[i];
    const auto& q = b.images[i];
    if (p.time_s != q.time_s || p.centre_px.x != q.centre_px.x || p.centre_px.y != q.centre_px.y ||
        p.diameter_px != q.diameter_px || p.equator_rad != q.equator_rad || p.leg != q.leg)
      return false;
  }
  return true;
}

/// Every effect and every spread on.
Scene busy_scene() {
  Scene scene;
  scene.name = "busy";
  scene.machine.speed_sd_mps = 0.3;
  scene.machine.spin_sd_radps = 20.0;
  scene.bounce.e_speed_mps = 6.6;
  scene.bounce.e_sd = scene.bounce.mu_sd = scene.bounce.offset_share_sd = 0.02;
  scene.bounce.dwell_sd_s = 0.2e-3;
  scene.lamps.flash_s = 5e-6;
  scene.camera.distance_m = 1.5;
  scene.camera.off_plane_sd_m = 0.01;
  scene.camera.distortion = 0.02;
  scene.camera.pixels = true;
  scene.faults = {{.kind = FaultKind::flash_late, .flash_from_impact = -2, .delay = microseconds(160)}};
  return scene;
}

std::string bytes_of(std::uint64_t seed, int shots) {
  auto shooter = Shooter::make(busy_scene(), seed);
  std::string text;
  for (int shot = 1; shot <= shots; ++shot) {
    const SimulatedShot result = shooter->shoot(shot);
    text +=
        messages::frame_to_json(result.frame) + '\n' + truth_line(shooter->scene(), result.exposure, shot);
  }
  return text;
}

}  // namespace

TEST_GROUP(Shoot) { Scene scene = scene_of_a_bounce(); };

TEST(Shoot, GivesAFrameThatReducesToTheTruth) {
  scene.tablet.centre_sd_m = 1e-5;
  scene.tablet.equator_sd_rad = 1e-4;
  const auto shot = shoot(scene, 3, 1, Model::full(), {.perfect_digitizer = true});
  CHECK(shot.has_value() && shot->flags.none());
  const auto readout = reduction::reduce(shot->frame, reduction::Estimator::best);
  CHECK(readout.has_value());
  // Sensors jitter by .2 µs, 3.4 µm of the ball's way, over legs of some 15 ms: below 1e-3 m/s.
  DOUBLES_EQUAL(*shot->truth[Quantity::vx_td_mps], *readout->value[Quantity::vx_td_mps], 5e-3);
  DOUBLES_EQUAL(*shot->truth[Quantity::vy_lo_mps], *readout->value[Quantity::vy_lo_mps], 5e-3);
  DOUBLES_EQUAL(*shot->truth[Quantity::omega_lo_radps], *readout->value[Quantity::omega_lo_radps], 0.5);
}

TEST(Shoot, DigitizesTheFirstOfSeveralBounces) {
  scene.machine.speed_mps = 2.0;
  scene.machine.angle_rad = -1.0;
  scene.bounce.count = 3;
  const ShootSettings settings{.period = milliseconds(10), .exposure = milliseconds(800)};
  const auto shot = shoot(scene, 3, 1, Model::full(), settings);
  CHECK(shot.has_value() && shot->exposure.ball.has_value());
  const auto& ball = *shot->exposure.ball;
  int later = 0;
  for (const FilmImage& film : film_images(scene, shot->exposure))
    later += ball.path.bounced_again(to_seconds(film.time - ball.touchdown)) ? 1 : 0;
  CHECK(later > 5);
  CHECK(shot->frame.images.size() > 10);
  for (const int pulse : shot->image_pulse) {
    const MonoTime time = flash_time(shot->exposure.pulses[static_cast<std::size_t>(pulse)]);
    CHECK(!ball.path.bounced_again(to_seconds(time - ball.touchdown)));
  }
}

TEST(Shoot, DoesNotDependOnWhatWasShotBefore) {
  auto shooter = Shooter::make(scene, 5);
  for (const int i : {1, 3, 2}) shooter->shoot(i);
  const SimulatedShot again = shooter->shoot(2);
  const auto alone = shoot(scene, 5, 2);
  LONGS_EQUAL(2, again.frame.shot_id);
  CHECK(same(again.frame, alone->frame));
  CHECK(!same(again.frame, shooter->shoot(3).frame));
}

TEST(Shoot, SharesItsRandomNumbersBetweenModels) {
  const auto full = shoot(scene, 5, 2);
  const auto bare = shoot(scene, 5, 2, Model::full().without(Effect::lamp_jitter));
  LONGS_EQUAL(full->frame.images.size(), bare->frame.images.size());
  // A microsecond of the ball's way: .017 mm or .07 px; other noise would be some pixels.
  for (std::size_t i = 0; i < full->frame.images.size(); ++i)
    DOUBLES_EQUAL(full->frame.images[i].centre_px.x, bare->frame.images[i].centre_px.x, 0.5);
}

TEST(Shoot, TakesTheTimesFromTheSensors) {
  scene.lamps.jitter_s = 20e-6;
  scene.sensors.jitter_s = 0.0;
  scene.sensors.delay_s = 3e-6;
  const auto shot = shoot(scene, 5, 2);
  const auto& images = shot->frame.images;
  DOUBLES_EQUAL(0.0, images[0].time_s, 0.0);
  const Pulse& first = shot->exposure.pulses[static_cast<std::size_t>(shot->image_pulse[0])];
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Pulse& pulse = shot->exposure.pulses[static_cast<std::size_t>(shot->image_pulse[i])];
    DOUBLES_EQUAL(to_seconds(flash_time(pulse) - flash_time(first)), images[i].time_s, 1.1e-9);
  }
}

TEST(Shoot, SaysThatTheBallMissed) {
  scene.faults = {{.kind = FaultKind::ball_misses, .shot = 2}};
  const auto shot = shoot(scene, 5, 2);
  CHECK(shot->has(ShotFlag::ball_missed));
  CHECK(shot->frame.images.empty());
  CHECK(!shot->truth[Quantity::e].has_value());
  scene.faults = {{.kind = FaultKind::machine_misfire}};
  CHECK(shoot(scene, 5, 2)->has(ShotFlag::no_ball));
}

TEST(Shoot, LeavesOutAnImageThatNoSensorTimed) {
  scene.faults = {{.kind = FaultKind::sensor_dropout, .flash_from_impact = -2}};
  const auto whole = shoot(scene_of_a_bounce(), 5, 2);
  const auto shot = shoot(scene, 5, 2);
  CHECK(shot->has(ShotFlag::unstamped_image));
  LONGS_EQUAL(whole->frame.images.size() - 1, shot->frame.images.size());
}

TEST(Shoot, RefusesSettingsOutOfRange) {
  CHECK(!shoot(scene, 5, 2, Model::full(), {.period = microseconds(10)}));
  CHECK(!shoot(scene, 5, 2, Model::full(), {.exposure = milliseconds(3000)}));
  CHECK(!shoot(scene, 5, 0));
}

// The same scene and seed give the same bytes, whatever the machine's load and in whichever thread.

TEST_GROUP(ShootRepeat){};

TEST(ShootRepeat, GivesTheSameBytesInAnotherThreadUnderLoad) {
  constexpr int kShots = 12;
  const std::string quiet = bytes_of(7, kShots);
  std::atomic<bool> done{false};
  std::string loaded, beside;
  {
    const std::jthread load([&] {
      for (volatile unsigned spin = 0; !done;) spin = spin + 1;
    });
    const std::jthread other([&] { beside = bytes_of(8, kShots); });
    std::jthread([&] { loaded = bytes_of(7, kShots); }).join();
    done = true;
  }
  CHECK_EQUAL(loaded, quiet);
  CHECK(quiet != beside);
  CHECK_EQUAL(bytes_of(8, kShots), beside);
}
