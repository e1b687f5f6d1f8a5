#include "sim/rig/rig.hpp"

#include <algorithm>
#include <cmath>

#include "sim/rig/tablet.hpp"
#include "sim/rig/truth.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include "tests/support/string_from.hpp"

namespace {

using namespace strobe;
using namespace strobe::sim;

/// Index of the pulse that far from the touchdown.
std::size_t pulse_at(const Exposure& exposure, int from_impact) {
  for (std::size_t i = 0; i < exposure.pulses.size(); ++i)
    if (*place_from_impact(exposure, i) == from_impact) return i;
  FAIL("no such pulse");
  return 0;
}

}  // namespace

TEST_GROUP(Rig) {
  Scene scene = test::plain_scene();
  std::vector<Drive> drives;
  std::vector<Exposure> exposures;

  static void pulse(Rig & rig, RigLine line, std::int64_t on_ns, std::int64_t off_ns) {
    rig.line_changed(line, 1, from_ns(on_ns));
    rig.line_changed(line, 0, from_ns(off_ns));
  }
};

TEST(Rig, AnswersEveryPulseWithBothSensorsAtTheTrueFlashes) {
  scene.lamps.jitter_s = 1e-6;
  scene.sensors.delay_s = 2e-6;
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(167, exposure.pulses.size());  // 500 ms at 3 ms
  for (const RigLine line : {RigLine::sensor_a, RigLine::sensor_b}) {
    const auto rises = fixture.drives_of(line, 1);
    const auto falls = fixture.drives_of(line, 0);
    LONGS_EQUAL(167, rises.size());
    LONGS_EQUAL(167, falls.size());
    const std::size_t lamp = line == RigLine::sensor_a ? 0 : 1;
    for (std::size_t i = 0; i < rises.size(); ++i) {
      CHECK_EQUAL(exposure.pulses[i].flashes[lamp] + microseconds(2), rises[i].at);
      CHECK_EQUAL(microseconds(100), falls[i].at - rises[i].at);
    }
  }
}

TEST(Rig, GivesNothingBeforeItsInstant) {
  Rig rig(scene, 1, MonoTime{});
  rig.line_changed(RigLine::strobe_a, 1, from_ns(1000000));
  CHECK_EQUAL(from_ns(1012000), rig.next_due());
  rig.collect(from_ns(1011999), drives, exposures);
  CHECK(drives.empty());
  rig.collect(from_ns(1012000), drives, exposures);
  LONGS_EQUAL(1, drives.size());
  CHECK(drives[0].line == RigLine::sensor_a && drives[0].at == from_ns(1012000));
}

TEST(Rig, OpensAndClosesTheShutterItsLagsAfterTheLine) {
  scene.shutter.open_lag_s = 0.045;
  scene.shutter.close_lag_s = 0.030;
  auto [fixture, exposure] = test::shot_of(scene);
  CHECK_EQUAL(milliseconds(45), exposure.opened - exposure.line_on);
  CHECK_EQUAL(milliseconds(530), exposure.closed - exposure.line_on);
}

TEST(Rig, TakesNoPhotographWhenTheLineIsReleasedBeforeTheShutterMoved) {
  Rig rig(scene, 1, MonoTime{});
  pulse(rig, RigLine::shutter, 0, 10'000'000);
  rig.collect(from_ns(1'000'000'000), drives, exposures);
  LONGS_EQUAL(1, exposures.size());
  CHECK(!known(exposures[0].opened));
  CHECK(film_images(scene, exposures[0]).empty());
}

TEST(Rig, MeetsThePlateTheMachinesLagAfterTheTrigger) {
  auto [fixture, exposure] = test::shot_of(scene);
  CHECK(exposure.ball.has_value());
  LONGS_EQUAL(1, exposure.throws);
  // The trigger was set such that the ball meets the plate 250 ms after the shutter opened.
  CHECK_EQUAL(milliseconds(250), exposure.ball->touchdown - exposure.opened);
}

TEST(Rig, SpreadsTheMachinesLagFromShotToShot) {
  scene.machine.lag_sd_s = 0.003;
  test::VirtualRigFixture fixture(scene);
  double sum = 0.0, square = 0.0;
  constexpr int n = 500;
  for (int i = 0; i < n; ++i) {
    const Exposure e = fixture.shoot({.exposure = milliseconds(100), .impact_after = milliseconds(50)});
    const double late_ms = to_seconds(e.ball->touchdown - e.opened) * 1e3 - 50.0;
    sum += late_ms / n;
    square += late_ms * late_ms / n;
  }
  DOUBLES_EQUAL(0.0, sum, 4.0 * 3.0 / std::sqrt(n));
  DOUBLES_EQUAL(3.0, std::sqrt(square), 4.0 * 3.0 / std::sqrt(2.0 * n));
}

TEST(Rig, ClosesTheGateWhileTheBallIsInItsBeam) {
  // Beam 1 m ahead of the plate; the ball's edge meets it a radius earlier. In a vacuum vx does not change.
  scene.air.density_kgpm3 = 0.0;
  auto [fixture, exposure] = test::shot_of(scene);
  const double vx = 17.0 * std::cos(23.0 * std::numbers::pi / 180.0);
  const auto rise = fixture.drives_of(RigLine::gate, 1);
  const auto fall = fixture.drives_of(RigLine::gate, 0);
  LONGS_EQUAL(1, rise.size());
  LONGS_EQUAL(1, fall.size());
  DOUBLES_EQUAL(-(1.0 + 0.03255) / vx, to_seconds(rise[0].at - exposure.ball->touchdown), 2e-9);
  DOUBLES_EQUAL(-(1.0 - 0.03255) / vx, to_seconds(fall[0].at - exposure.ball->touchdown), 2e-9);
}

TEST(Rig, PhotographsTheBallOnlyWhileTheShutterIsOpen) {
  test::VirtualRigFixture fixture(scene);
  const Exposure early = fixture.shoot({.impact_after = milliseconds(700)});
  CHECK(early.ball.has_value());
  CHECK(!shows_impact(early));
  CHECK(film_images(scene, early).empty());
  CHECK(shows_impact(fixture.shoot()));
}

TEST(Rig, PhotographsNoFlashAfterTheShutterHasClosed) {
  test::VirtualRigFixture fixture(scene);
  Exposure exposure = fixture.shoot();
  const std::size_t all = film_images(scene, exposure).size();
  exposure.closed = exposure.ball->touchdown;
  const auto images = film_images(scene, exposure);
  CHECK(!images.empty() && images.size() < all);
  for (const FilmImage& image : images) CHECK(image.time <= exposure.closed);
}

TEST(Rig, PhotographsNoBallThatWouldHaveMetThePlateAgain) {
  // Rises at 1 m/s from a steep impact: down again after 0.2 s, still in view.
  scene.machine.speed_mps = 5.0;
  scene.machine.angle_rad = -80.0 * std::numbers::pi / 180.0;
  scene.bounce.e = 0.2;
  scene.bounce.e_speed_mps = 5.0;
  auto [fixture, exposure] = test::shot_of(scene);
  const auto images = film_images(scene, exposure);
  CHECK(images.back().time < exposure.ball->touchdown + milliseconds(225));
  CHECK(images.back().time > exposure.ball->touchdown + milliseconds(150));
}

TEST(Rig, NumbersAnExposuresFlashesFromItsOwnFirst) {
  scene.faults = {{.kind = FaultKind::flash_missing, .flash_index = 0}};
  Rig rig(scene, 1, MonoTime{});
  const auto flash = [&rig](std::int64_t at_ns) { pulse(rig, RigLine::strobe_a, at_ns, at_ns + 50'000); };
  flash(10'000'000);
  flash(20'000'000);
  rig.line_changed(RigLine::shutter, 1, from_ns(30'000'000));
  flash(100'000'000);
  flash(110'000'000);
  rig.finish(from_ns(200'000'000), exposures);
  LONGS_EQUAL(2, exposures[0].pulses.size());
  CHECK(exposures[0].pulses[0].flashes.empty());
  LONGS_EQUAL(1, exposures[0].pulses[1].flashes.size());
}

TEST(Rig, LeavesTheGateAloneIfTheMachineStandsBeyondIt) {
  scene.gate.distance_m = 10.0;  // the ball would have passed it before it was thrown
  test::VirtualRigFixture fixture(scene);
  CHECK(fixture.shoot().ball.has_value());
  CHECK(fixture.drives_of(RigLine::gate, 1).empty());
}

TEST(Rig, HasNoBallOrExposureFromBeforeARestart) {
  Rig rig(scene, 1, MonoTime{});
  pulse(rig, RigLine::shutter, 0, 100'000'000);
  pulse(rig, RigLine::shutter, 110'000'000, 200'000'000);
  rig.restart(1, from_ns(1'000'000'000));
  rig.collect(from_ns(1'000'000'000), drives, exposures);
  CHECK(exposures.empty());
  rig.line_changed(RigLine::trigger, 1, from_ns(1'000'000'000));
  rig.restart(1, from_ns(1'100'000'000));
  rig.line_changed(RigLine::shutter, 1, from_ns(1'100'000'000));
  rig.finish(from_ns(2'000'000'000), exposures);
  LONGS_EQUAL(1, exposures.size());
  LONGS_EQUAL(0, exposures[0].throws);
}

TEST(Rig, MakesAnImageWithOneLampAlone) {
  scene.faults = {{.kind = FaultKind::lamp_dead, .lamp_b = false}};
  auto [fixture, exposure] = test::shot_of(scene);
  CHECK(film_images(scene, exposure).size() >= 10);
  CHECK(fixture.drives_of(RigLine::sensor_a, 1).empty());
  LONGS_EQUAL(exposure.pulses.size(), fixture.drives_of(RigLine::sensor_b, 1).size());
  CHECK(exposure.has(FaultKind::lamp_dead));
}

TEST(Rig, MakesNoImageWhereBothLampsMiss) {
  test::VirtualRigFixture sound(scene);
  const std::size_t whole = film_images(scene, sound.shoot()).size();
  scene.faults = {{.kind = FaultKind::flash_missing, .flash_from_impact = 2}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(whole - 1, film_images(scene, exposure).size());
  CHECK(exposure.pulses[pulse_at(exposure, 2)].flashes.empty());
  CHECK(!known(flash_time(exposure.pulses[pulse_at(exposure, 2)])));
}

TEST(Rig, StrikesTheFlashThatTheFaultCountsFromTheImpact) {
  for (const int k : {-4, -3, -2, -1, 1, 2, 3}) {
    scene.faults = {
        {.kind = FaultKind::flash_late, .shot = 2, .flash_from_impact = k, .delay = microseconds(160)}};
    scene.machine.lag_sd_s = 0.003;
    test::VirtualRigFixture fixture(scene);
    for (int shot = 1; shot <= 3; ++shot) {
      const Exposure exposure = fixture.shoot();
      CHECK_EQUAL(shot == 2, exposure.has(FaultKind::flash_late));
      for (std::size_t i = 0; i < exposure.pulses.size(); ++i) {
        const bool late = flash_time(exposure.pulses[i]) - exposure.pulses[i].edge > microseconds(100);
        CHECK_EQUAL(shot == 2 && *place_from_impact(exposure, i) == k, late);
      }
    }
  }
}

TEST(Rig, BlendsTheTwoLampsOfAPulseIntoOneImageBetweenThem) {
  scene.faults = {
      {.kind = FaultKind::flash_late, .flash_from_impact = -2, .lamp_b = false, .delay = microseconds(160)}};
  auto [fixture, exposure] = test::shot_of(scene);
  const auto late = static_cast<int>(pulse_at(exposure, -2));
  int seen = 0;
  for (const FilmImage& image : film_images(scene, exposure)) {
    if (image.pulse != late) continue;
    ++seen;
    CHECK_EQUAL(microseconds(12 + 80), image.time - exposure.pulses[static_cast<std::size_t>(late)].edge);
  }
  LONGS_EQUAL(1, seen);
}

TEST(Rig, ShowsADoubleFlashFarApartAsTwoImagesAndTwoEdges) {
  scene.faults = {{.kind = FaultKind::flash_double, .flash_from_impact = -2, .delay = microseconds(900)}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(exposure.pulses.size() + 1, fixture.drives_of(RigLine::sensor_a, 1).size());
  const auto images = film_images(scene, exposure);
  const auto from_it =
      std::ranges::count(images, static_cast<int>(pulse_at(exposure, -2)), &FilmImage::pulse);
  LONGS_EQUAL(2, from_it);
}

TEST(Rig, LengthensASensorsPulseByLightThatComesDuringIt) {
  scene.faults = {{.kind = FaultKind::flash_double, .flash_index = 5, .delay = microseconds(60)}};
  auto [fixture, exposure] = test::shot_of(scene);
  const auto rises = fixture.drives_of(RigLine::sensor_a, 1);
  const auto falls = fixture.drives_of(RigLine::sensor_a, 0);
  LONGS_EQUAL(exposure.pulses.size(), rises.size());
  LONGS_EQUAL(exposure.pulses.size(), falls.size());
  CHECK_EQUAL(microseconds(160), falls[5].at - rises[5].at);
}

TEST(Rig, SilencesADeadSensorButNotItsLamp) {
  scene.faults = {{.kind = FaultKind::sensor_dead, .lamp_a = false}};
  auto [fixture, exposure] = test::shot_of(scene);
  CHECK(fixture.drives_of(RigLine::sensor_b, 1).empty());
  for (const Pulse& pulse : exposure.pulses) LONGS_EQUAL(2, pulse.flashes.size());
}

TEST(Rig, CrossesTheGateWithABallThatMissesThePlate) {
  scene.faults = {{.kind = FaultKind::ball_misses, .shot = 1}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(1, fixture.drives_of(RigLine::gate, 1).size());
  LONGS_EQUAL(1, exposure.throws);
  CHECK(!exposure.ball.has_value());
  CHECK(exposure.has(FaultKind::ball_misses));
  CHECK(fixture.shoot().ball.has_value());
}

TEST(Rig, ThrowsNothingWhenTheMachineMisfires) {
  scene.faults = {{.kind = FaultKind::machine_misfire, .shot = 1}};
  auto [fixture, exposure] = test::shot_of(scene);
  LONGS_EQUAL(0, exposure.throws);
  CHECK(fixture.drives_of(RigLine::gate, 1).empty());
  CHECK(exposure.has(FaultKind::machine_misfire));
}

TEST(Rig, CountsEveryThrowOfAShot) {
  Rig rig(scene, 1, MonoTime{});
  rig.line_changed(RigLine::shutter, 1, MonoTime{});
  for (int i = 0; i < 3; ++i)
    pulse(rig, RigLine::trigger, 50'000'000LL * (i + 1), 50'000'000LL * (i + 1) + 20'000'000);
  rig.finish(from_ns(500'000'000), exposures);
  LONGS_EQUAL(1, exposures.size());
  LONGS_EQUAL(3, exposures[0].throws);
}

TEST(Rig, TellsWhenTheShutterIsOpenByItsContact) {
  scene.shutter.lag_sd_s = 1e-3;
  auto [fixture, exposure] = test::shot_of(scene);
  const auto opened = fixture.drives_of(RigLine::xsync, 1), closed = fixture.drives_of(RigLine::xsync, 0);
  LONGS_EQUAL(1, opened.size());
  LONGS_EQUAL(1, closed.size());
  CHECK_EQUAL(exposure.opened, opened[0].at);
  CHECK_EQUAL(exposure.closed, closed[0].at);
}

TEST(Rig, TellsNothingOfAShutterThatDoesNotMove) {
  scene.faults = {{.kind = FaultKind::shutter_stuck}};
  test::VirtualRigFixture stuck(scene);
  stuck.shoot();
  CHECK(stuck.drives_of(RigLine::xsync, 1).empty());
  scene.faults.clear();
  Rig rig(scene, 1, MonoTime{});
  pulse(rig, RigLine::shutter, 0, 1'000'000);  // let go long before it opens
  rig.collect(from_ns(1'000'000'000), drives, exposures);
  CHECK(drives.empty());
}

TEST(Rig, FlashesTheLampWhoseLineRises) {
  Rig rig(scene, 1, MonoTime{});
  rig.line_changed(RigLine::shutter, 1, MonoTime{});
  for (int k = 0; k < 4; ++k) {
    const RigLine lamp = k % 2 == 0 ? RigLine::strobe_a : RigLine::strobe_b;
    pulse(rig, lamp, 100'000'000 + 800'000 * k, 100'050'000 + 800'000 * k);
  }
  rig.finish(from_ns(500'000'000), exposures);
  LONGS_EQUAL(4, exposures[0].pulses.size());
  for (std::size_t k = 0; k < 4; ++k) {
    const Pulse& pulse = exposures[0].pulses[k];
    LONGS_EQUAL(1, pulse.flashes.size());
    LONGS_EQUAL(k % 2 == 0 ? 1 : 0, pulse.lamps[0]);
    LONGS_EQUAL(k % 2 == 0 ? 0 : 1, pulse.lamps[1]);
  }
}

TEST(Rig, ForgetsABallThrownLongBeforeTheShutterOpens) {
  Rig rig(scene, 1, MonoTime{});
  rig.line_changed(RigLine::trigger, 1, MonoTime{});
  rig.line_changed(RigLine::shutter, 1, from_ns(20'000'000'000));
  rig.finish(from_ns(21'000'000'000), exposures);
  CHECK(!exposures[0].ball.has_value());
}

TEST(Rig, DoesWhatTheOperatorDoes) {
  scene.operator_actions = {{.at_s = 0.5, .line = RigLine::estop, .level = 0},
                            {.at_s = 0.2, .line = RigLine::key, .level = 0}};
  Rig rig(scene, 1, from_ns(1'000'000'000));
  CHECK_EQUAL(from_ns(1'200'000'000), rig.next_due());
  rig.collect(from_ns(2'000'000'000), drives, exposures);
  LONGS_EQUAL(2, drives.size());
  CHECK(drives[0].line == RigLine::key && drives[1].line == RigLine::estop);
  CHECK_EQUAL(from_ns(1'500'000'000), drives[1].at);
}

TEST(Rig, KeepsBothExposuresWhenTheShutterOpensAgainAtOnce) {
  Rig rig(scene, 1, MonoTime{});
  pulse(rig, RigLine::shutter, 0, 100'000'000);
  pulse(rig, RigLine::shutter, 110'000'000, 300'000'000);
  rig.collect(from_ns(1'000'000'000), drives, exposures);
  LONGS_EQUAL(2, exposures.size());
  LONGS_EQUAL(1, exposures[0].shot);
  LONGS_EQUAL(2, exposures[1].shot);
}

TEST(Rig, ReturnsAnExposureWhenItsLastEdgesMustHaveBeenReported) {
  Rig rig(scene, 1, MonoTime{});
  pulse(rig, RigLine::shutter, 0, 100'000'000);
  // Closed 45 ms after its line; edges may be reported for another 20 ms.
  rig.collect(from_ns(164'999'999), drives, exposures);
  CHECK(exposures.empty());
  CHECK_EQUAL(from_ns(165'000'000), rig.next_due());
  CHECK_EQUAL(MonoTime{}, rig.exposing_since());
  rig.collect(from_ns(165'000'000), drives, exposures);
  LONGS_EQUAL(1, exposures.size());
  CHECK_EQUAL(from_ns(145'000'000), exposures[0].closed);
  CHECK(!rig.exposing_since());
}

TEST(Rig, ClosesAnOpenShutterAtTheEndAsIfItsLineWereReleasedThen) {
  Rig rig(scene, 1, MonoTime{});
  rig.line_changed(RigLine::shutter, 1, MonoTime{});
  rig.finish(from_ns(500'000'000), exposures);
  LONGS_EQUAL(1, exposures.size());
  CHECK_EQUAL(from_ns(545'000'000), exposures[0].closed);
}

TEST(Rig, MarksOnlyTheExposureDuringWhichItFellBehind) {
  Rig rig(scene, 1, MonoTime{});
  rig.mark_overrun();  // between exposures
  for (const std::int64_t start_ns : {0, 1'000'000'000, 2'000'000'000}) {
    rig.line_changed(RigLine::shutter, 1, from_ns(start_ns));
    if (start_ns == 1'000'000'000) rig.mark_overrun();
    rig.finish(from_ns(start_ns + 500'000'000), exposures);
    rig.line_changed(RigLine::shutter, 0, from_ns(start_ns + 500'000'000));
  }
  LONGS_EQUAL(3, exposures.size());
  CHECK(!exposures[0].overrun && exposures[1].overrun && !exposures[2].overrun);
}

TEST(Rig, RepeatsARunFromItsSeed) {
  scene.machine.speed_sd_mps = 0.5;
  scene.tablet.centre_sd_m = 0.3e-3;
  scene.lamps.jitter_s = 1e-6;
  test::VirtualRigFixture a(scene, 11);
  test::VirtualRigFixture b(scene, 11);
  test::VirtualRigFixture other(scene, 12);
  for (int shot = 1; shot <= 3; ++shot) {
    const std::string line = truth_line(scene, a.shoot(), shot);
    CHECK_EQUAL(line, truth_line(scene, b.shoot(), shot));
    CHECK(line != truth_line(scene, other.shoot(), shot));
  }
}

TEST(Rig, ThrowsTheSameBallHoweverManyFlashesCameBefore) {
  scene.machine.speed_sd_mps = 0.5;
  scene.lamps.jitter_s = 1e-6;
  test::VirtualRigFixture few(scene, 11);
  test::VirtualRigFixture many(scene, 11);
  few.shoot({.period = milliseconds(10)});
  many.shoot({.period = milliseconds(2)});
  const Exposure a = few.shoot();
  const Exposure b = many.shoot();
  DOUBLES_EQUAL(a.ball->path.touchdown().vx_mps, b.ball->path.touchdown().vx_mps, 0.0);
  CHECK_EQUAL(b.pulses[7].flashes[0] - b.pulses[7].edge, a.pulses[7].flashes[0] - a.pulses[7].edge);
}
