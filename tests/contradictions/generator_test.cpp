// The generator against closed forms and against itself: a judge is as good as its truth.
#include <algorithm>
#include <cmath>
#include <string>

#include "common/reduction/reduce.hpp"
#include "tests/contradictions/shot.hpp"
#include "tests/support/repetitions.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::contradictions;
using strobe::testing::repetitions;

namespace {

constexpr double kGravity = 9.80665;

Motion thrown() {
  return {.x_m = 0.0, .y_m = 0.5, .vx_mps = 15.0, .vy_mps = -7.0, .angle_rad = 0.3, .omega_radps = 250.0};
}

double speed(const Motion& m) { return std::hypot(m.vx_mps, m.vy_mps); }

}  // namespace

TEST_GROUP(GeneratorFlight){};

// Fourth-order steps of 2 ms: (0.6 / s x 2 ms)^4 of the forces' part a step, 1e-12; 1e-10 leaves room for 50 steps.

TEST(GeneratorFlight, WithoutAirIsAParabola) {
  const double t = 0.1;
  const Motion m = flown(thrown(), {.gx_mps2 = 2.0, .gy_mps2 = -kGravity}, t);
  DOUBLES_EQUAL(15.0 * t + 0.5 * 2.0 * t * t, m.x_m, 1e-12);
  DOUBLES_EQUAL(0.5 - 7.0 * t - 0.5 * kGravity * t * t, m.y_m, 1e-12);
  DOUBLES_EQUAL(-7.0 - kGravity * t, m.vy_mps, 1e-12);
  DOUBLES_EQUAL(0.3 + 250.0 * t, m.angle_rad, 1e-12);
}

TEST(GeneratorFlight, WithoutDragKeepsItsEnergy) {
  const Forces f{.gy_mps2 = -kGravity, .lift_per_m = 0.035};
  const Motion m = flown(thrown(), f, 0.1);
  const auto energy = [](const Motion& s) { return 0.5 * speed(s) * speed(s) + kGravity * s.y_m; };
  DOUBLES_EQUAL(energy(thrown()), energy(m), 1e-9);
}

TEST(GeneratorFlight, WithDragAloneSlowsHyperbolically) {
  const double k = 0.02, t = 0.08, v = speed(thrown());
  const Motion m = flown(thrown(), {.drag_per_m = k, .decay_per_m = 0.01}, t);
  DOUBLES_EQUAL(v / (1.0 + k * v * t), speed(m), 1e-10);
  const double path = std::log(1.0 + k * v * t) / k;
  DOUBLES_EQUAL(path, std::hypot(m.x_m, m.y_m - 0.5), 1e-10);
  DOUBLES_EQUAL(250.0 * std::exp(-0.01 * path), m.omega_radps, 1e-8);
}

TEST(GeneratorFlight, WithLiftAloneIsACircleAndBackspinLifts) {
  const Forces f{.lift_per_m = 0.035, .radius_m = 0.0325};
  const double t = 0.05, v = speed(thrown()), rim = 0.0325 * 250.0;
  const Motion m = flown(thrown(), f, t);
  const double turned = 0.035 * rim / (2.0 * rim + v) * v * t;
  DOUBLES_EQUAL(std::atan2(-7.0, 15.0) + turned, std::atan2(m.vy_mps, m.vx_mps), 1e-10);
  DOUBLES_EQUAL(v, speed(m), 1e-10);
}

TEST(GeneratorFlight, BackwardsReturnsToItsStart) {
  const Forces f{
      .gx_mps2 = 1.0, .gy_mps2 = -kGravity, .drag_per_m = 0.02, .lift_per_m = 0.035, .decay_per_m = 0.01};
  const Motion back = flown(flown(thrown(), f, 0.06), f, -0.06);
  DOUBLES_EQUAL(thrown().x_m, back.x_m, 1e-10);
  DOUBLES_EQUAL(thrown().vy_mps, back.vy_mps, 1e-10);
  DOUBLES_EQUAL(thrown().omega_radps, back.omega_radps, 1e-9);
}

TEST_GROUP(GeneratorBounce){};

TEST(GeneratorBounce, ABallThatGripsWithoutTangentialRestitutionRolls) {
  Scene scene;
  scene.impact = {.vx_mps = 10.0, .vy_mps = -10.0, .omega_radps = 100.0, .mu = 0.8};
  const Bounce b = bounce(scene);
  CHECK_FALSE(b.slid);
  DOUBLES_EQUAL(0.0, b.lo.vx_mps + scene.radius_m() * b.lo.omega_radps, 1e-12);
  DOUBLES_EQUAL(0.0, truth(scene).missing_mps, 1e-12);
}

TEST(GeneratorBounce, ABallThatSlidesLosesTheFrictionsImpulse) {
  Scene scene;
  scene.impact = {.vx_mps = 20.0, .vy_mps = -5.0, .omega_radps = 0.0, .e = 0.8, .mu = 0.4};
  const Bounce b = bounce(scene);
  CHECK_TRUE(b.slid);
  DOUBLES_EQUAL(20.0 - 0.4 * 1.8 * 5.0, b.lo.vx_mps, 1e-12);
  DOUBLES_EQUAL(0.4, *truth(scene).value[reduction::Quantity::mu], 1e-12);
  CHECK(truth(scene).missing_mps > 0.0);
}

TEST(GeneratorBounce, WithoutAnOffsetGainsNoEnergyAndKeepsTheMomentumAboutTheContact) {
  for (std::uint64_t number = 1; number <= 1000; ++number) {
    Random random(1, 0, number);
    Scene scene = drawn_scene({}, random);
    scene.impact.offset_m = 0.0;
    const Bounce b = bounce(scene);
    const double r = scene.radius_m();
    const auto energy = [&](const Motion& m) {
      return speed(m) * speed(m) + scene.alpha * r * r * m.omega_radps * m.omega_radps;
    };
    CHECK(energy(b.lo) <= energy(b.td) * (1.0 + 1e-12));
    DOUBLES_EQUAL(b.td.vx_mps - scene.alpha * r * b.td.omega_radps,
                  b.lo.vx_mps - scene.alpha * r * b.lo.omega_radps, 1e-11);
  }
}

TEST_GROUP(GeneratorShots){};

TEST(GeneratorShots, RepeatFromTheirSeedAndNumber) {
  for (std::size_t k = 0; k < kKindCount; ++k) {
    const auto kind = static_cast<Kind>(k);
    const Shot a = drawn_shot(kind, {}, 5, 17), b = drawn_shot(kind, {}, 5, 17),
               other = drawn_shot(kind, {}, 5, 18);
    CHECK_EQUAL(a.photograph.frame.images.size(), b.photograph.frame.images.size());
    CHECK_EQUAL(a.photograph.frame.images.back().centre_px.x, b.photograph.frame.images.back().centre_px.x);
    CHECK(a.photograph.frame.images[0].centre_px.x != other.photograph.frame.images[0].centre_px.x);
  }
}

TEST(GeneratorShots, AreFramesThatCanBeReducedAndTroubled) {
  for (std::size_t k = 0; k < kKindCount; ++k) {
    const auto kind = static_cast<Kind>(k);
    for (std::uint64_t number = 1; number <= static_cast<std::uint64_t>(repetitions(200)); ++number) {
      const Shot shot = drawn_shot(kind, {}, 3, number);
      const auto readout = reduction::reduce(shot.photograph.frame, reduction::Estimator::best);
      CHECK_TEXT(readout.has_value(), std::string(name(kind)).c_str());
      CHECK_EQUAL(kind != Kind::none, shot.severity > 0.0);
    }
  }
}

TEST(GeneratorShots, HaveAtLeastTwoImagesALegAndAtMostThoseAskedFor) {
  Settings settings;
  settings.least_images = 3, settings.most_images = 6;
  for (std::uint64_t number = 1; number <= 500; ++number) {
    const Photograph p = drawn_shot(Kind::none, settings, 2, number).photograph;
    for (const Leg leg : {Leg::incoming, Leg::rebound}) {
      const auto count = std::count(p.legs.begin(), p.legs.end(), leg);
      CHECK(count >= 2 && count <= 6);
    }
  }
}

TEST(GeneratorShots, HaveTheNoiseThatTheyState) {
  // Diameters of undisturbed shots about the true one: some 20 a shot, so that the rms of 20,000 is within
  // 1 / sqrt(40,000) = 0.5 % of its sd; four times that.
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t number = 1; number <= 1000; ++number) {
    Random random(4, 0, number);
    Scene scene = drawn_scene({}, random);
    const Photograph p = photograph(scene, random);
    for (const auto& image : p.frame.images) {
      const double sd = image.diameter_sd_px.value_or(*p.frame.diameter_sd_px);
      const double z = (image.diameter_px - scene.px_per_m * scene.diameter_m) / sd;
      sum += z * z;
      ++count;
    }
  }
  DOUBLES_EQUAL(1.0, std::sqrt(sum / count), 0.02);
}

TEST(GeneratorShots, WithHardlyAnyNoiseAreReducedToTheirTruth) {
  // The tilt is told by the surface points, the scale by a calibration; noise of 1e-4 px of some 1000 is 1e-7.
  // What is left is the reduction's series (flight.hpp: 0.002 mm/s and 5 nm after 6 ms; legs of 30 ms here) and what
  // it does not know of the air: four of its own standard deviations.
  Settings settings;
  settings.least_images = 5, settings.most_images = 6;
  for (std::uint64_t number = 1; number <= 300; ++number) {
    Random random(6, 0, number);
    Scene scene = drawn_scene(settings, random);
    scene.stated = {1e-4, 1e-4, 1e-5, 1e-4};
    scene.time_sd_s = 0.0, scene.noise_by_image = false;
    scene.diameter_m = scene.told_diameter_m;
    scene.told_px_per_m = scene.px_per_m, scene.told_px_per_m_sd.reset();
    const Photograph p = photograph(scene, random);
    const auto readout = reduction::reduce(p.frame, reduction::Estimator::best, {.reject_outliers = false});
    const auto check = [&](reduction::Quantity q, double tolerance) {
      if (!readout->value[q]) return;
      const std::string where = std::string(reduction::name(q)) + " of shot " + std::to_string(number);
      const double sd = std::hypot(*readout->sd[q], readout->sd_systematic[q].value_or(0.0));
      DOUBLES_EQUAL_TEXT(*p.truth.value[q], *readout->value[q], tolerance + 4.0 * sd, where.c_str());
    };
    check(reduction::Quantity::vx_td_mps, 2e-3);
    check(reduction::Quantity::vy_lo_mps, 2e-3);
    check(reduction::Quantity::omega_td_radps, 0.1);
    check(reduction::Quantity::omega_lo_radps, 0.1);
    check(reduction::Quantity::dwell_time_ms, 2e-3);
    check(reduction::Quantity::e, 2e-4);
    CHECK_EQUAL(p.truth.mirrored, readout->mirrored);
  }
}
