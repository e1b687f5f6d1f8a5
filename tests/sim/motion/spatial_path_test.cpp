// Balls that leave the plane or spin about any axis: against steps of the equations of motion that share nothing with
// the paths, and against what must not change when all is turned or mirrored.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "sim/motion/ball_path.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kGravity_mps2 = 9.80665;
const std::vector<double> kTimes_s{-0.05, -0.02, -0.003, 0.0005, 0.002, 0.0045, 0.006, 0.02, 0.06};

Scene scene_of(ContactLaw law) {
  Scene scene = test::plain_scene();
  scene.bounce.contact = law;
  return scene;
}

ShotConditions thrown_of(const Scene& scene, double vz_mps, const Vector3d& spin_radps) {
  ShotConditions thrown = draw_shot_conditions(scene, 1, 1);
  thrown.touchdown.omega_radps = spin_radps.z();
  thrown.vz_mps = vz_mps;
  thrown.omega_x_radps = spin_radps.x();
  thrown.omega_y_radps = spin_radps.y();
  return thrown;
}

BallPath path_of(const Scene& scene, const ShotConditions& thrown) {
  auto path = BallPath::make(scene, thrown);
  if (!path) FAIL(path.error().message.c_str());
  return *path;
}

Vector3d spin_of(const BallState& s) { return {s.omega_x_radps, s.omega_y_radps, s.omega_radps}; }
Vector3d velocity_of(const BallState& s) { return {s.vx_mps, s.vy_mps, s.vz_mps}; }
Vector3d place_of(const BallState& s) { return {s.x_m, s.y_m, s.z_m}; }

void check_near(const Vector3d& expected, const Vector3d& actual, double tolerance, const std::string& what) {
  const double off = (expected - actual).norm();
  CHECK_TEXT(off <= tolerance, fmt::format("{}: off by {:.3g}", what, off).c_str());
}

void check_turned(const Matrix3d& expected, const Matrix3d& actual, double tolerance, const std::string& what) {
  const double off = (expected - actual).norm();
  CHECK_TEXT(off <= tolerance, fmt::format("{}: turned off by {:.3g}", what, off).c_str());
}

/// In steps of a microsecond each turned by the spin in its middle.
Matrix3d attitude_by_steps(const BallPath& path, double until_s) {
  constexpr double kStep_s = 1e-6;
  const int steps = static_cast<int>(std::round(std::abs(until_s) / kStep_s));
  const double h = until_s / steps;
  Matrix3d attitude = path.at(0.0).attitude();
  for (int i = 0; i < steps; ++i) {
    const Vector3d angle = h * spin_of(path.at((i + 0.5) * h));
    attitude = Eigen::AngleAxisd(angle.norm(), angle.normalized()).toRotationMatrix() * attitude;
  }
  return attitude;
}

}  // namespace

TEST_GROUP(SpatialPath){};

TEST(SpatialPath, TurnsAsSmallStepsOfItsSpinDo) {
  for (const ContactLaw law : {ContactLaw::ode, ContactLaw::grip}) {
    const Scene scene = scene_of(law);
    const BallPath path = path_of(scene, thrown_of(scene, 1.5, {120.0, -200.0, 150.0}));
    // The middle of a step: h²/24 of the spin's change of direction, of 500 rad/s in 5 ms at 300 rad/s, over 5 ms.
    for (const double time_s : {-0.01, 0.002, 0.006, 0.012})
      check_turned(attitude_by_steps(path, time_s), path.at(time_s).attitude(), 1e-6,
                   fmt::format("{} s", time_s));
  }
}

TEST(SpatialPath, FliesAsSmallStepsOfDragAndLiftDo) {
  const Scene scene = scene_of(ContactLaw::grip);
  const BallPath path = path_of(scene, thrown_of(scene, 2.0, {150.0, 250.0, -100.0}));
  // The formulas of flight.hpp with the default tennis ball and dry air of 21 degrees.
  const double radius = 0.5 * scene.ball.diameter_m;
  const double q = 101325.0 / (287.05 * 294.15) * M_PI * radius * radius / (2.0 * scene.ball.mass_kg);
  Vector3d p = place_of(path.at(0.0)), v = velocity_of(path.at(0.0)), w = spin_of(path.at(0.0));
  constexpr double h = -2e-6;
  const auto force = [&](const Vector3d& at_v, const Vector3d& at_w) -> Vector3d {
    const double speed = at_v.norm();
    const Vector3d across = at_w - at_w.dot(at_v) / (speed * speed) * at_v;
    const double ratio = radius * across.norm() / speed;
    const double lift = ratio / (2.0 * ratio + 1.0);
    return -q * 0.55 * speed * at_v + q * lift * speed * speed * across.cross(at_v).normalized() -
           Vector3d(0.0, kGravity_mps2, 0.0);
  };
  for (int i = 0; i < 25000; ++i) {
    const Vector3d a = force(v, w);
    const Vector3d v_middle = v + 0.5 * h * a;
    w -= h * 0.01 * v_middle.norm() * w;
    p += h * v_middle;
    v += h * force(v_middle, w);
  }
  const BallState s = path.at(-0.05);
  // The middle's rule: some h·(acceleration's rate) of 1e3 m/s³ over 50 ms, and of the spin h·decay.
  check_near(p, place_of(s), 1e-7, "place");
  check_near(v, velocity_of(s), 1e-6, "velocity");
  check_near(w, spin_of(s), 1e-4, "spin");
}

TEST(SpatialPath, KeepsEnergyAndSpinInFlightWithoutAir) {
  Scene scene = scene_of(ContactLaw::ode);
  scene.air.density_kgpm3 = scene.air.spin_decay_per_m = 0.0;
  const BallPath path = path_of(scene, thrown_of(scene, -3.0, {120.0, -200.0, 150.0}));
  for (const bool rebound : {false, true}) {
    const BallState start = path.at(rebound ? path.dwell_s() : 0.0);
    const auto energy = [&](const BallState& s) {
      return 0.5 * velocity_of(s).squaredNorm() + kGravity_mps2 * s.y_m;
    };
    for (const double away_s : {0.01, 0.04, 0.1}) {
      const BallState s = path.at(rebound ? path.dwell_s() + away_s : -away_s);
      DOUBLES_EQUAL(energy(start), energy(s), 1e-11);
      check_near(spin_of(start), spin_of(s), 1e-11, "spin");
    }
  }
}

// Turned about the surface's normal a planar shot is as it was, by other code: to the tolerance of the contact's
// mechanics, 1e-9 of each motion's scale, some 20 m/s and 600 rad/s.
TEST(SpatialPath, OfAPlanarShotThatIsTurnedIsTheTurnedOne) {
  for (const ContactLaw law : {ContactLaw::ode, ContactLaw::grip}) {
    const Scene scene = scene_of(law);
    for (const double spin_radps : {0.0, 250.0, -300.0}) {
      const ShotConditions flat = thrown_of(scene, 0.0, {0.0, 0.0, spin_radps});
      const BallPath planar = path_of(scene, flat);
      CHECK(planar.planar());
      const Matrix3d turn = Eigen::AngleAxisd(-0.6, Vector3d::UnitY()).toRotationMatrix();
      const Vector3d v = turn * Vector3d(flat.touchdown.vx_mps, 0.0, 0.0);
      ShotConditions aside = thrown_of(scene, v.z(), turn * Vector3d(0.0, 0.0, spin_radps));
      aside.touchdown.vx_mps = v.x();
      const BallPath path = path_of(scene, aside);
      CHECK(!path.planar());
      const Matrix3d first = planar.at(0.0).attitude();
      for (const double time_s : kTimes_s) {
        const BallState expected = planar.at(time_s), s = path.at(time_s);
        const std::string what = fmt::format("spin {}, {} s", spin_radps, time_s);
        check_near(turn * place_of(expected), place_of(s), 1e-8, what);
        check_near(turn * velocity_of(expected), velocity_of(s), 1e-6, what);
        check_near(turn * spin_of(expected), spin_of(s), 1e-4, what);
        check_turned(turn * expected.attitude() * first.transpose() * turn.transpose(),
                     s.attitude() * path.at(0.0).attitude().transpose(), 1e-6, what);
      }
    }
  }
}

TEST(SpatialPath, IsItsMirrorsImageWhereTheOtherSideIsThrownTo) {
  const Scene scene = scene_of(ContactLaw::ode);
  const BallPath path = path_of(scene, thrown_of(scene, 1.5, {120.0, -200.0, 150.0}));
  const BallPath other = path_of(scene, thrown_of(scene, -1.5, {-120.0, 200.0, 150.0}));
  for (const double time_s : kTimes_s) {
    const BallState a = path.at(time_s), b = other.at(time_s);
    check_near(place_of(a), {b.x_m, b.y_m, -b.z_m}, 1e-9, fmt::format("{} s", time_s));
    check_near(spin_of(a), {-b.omega_x_radps, -b.omega_y_radps, b.omega_radps}, 1e-5, "spin");
  }
}

TEST(SpatialPath, KeepsItsPlanarDrawsWhereSpinsOutOfThePlaneAreAdded) {
  Scene scene = test::plain_scene();
  scene.machine.speed_sd_mps = 1.0;
  scene.bounce.mu_sd = 0.05;
  Scene spatial = scene;
  spatial.machine.sidespin_radps = 100.0;
  spatial.machine.sidespin_sd_radps = 20.0;
  const ShotConditions a = draw_shot_conditions(scene, 5, 3), b = draw_shot_conditions(spatial, 5, 3);
  CHECK(a.planar());
  CHECK(b.omega_y_radps != 0.0 && b.omega_y_radps != 100.0);
  DOUBLES_EQUAL(a.touchdown.vx_mps, b.touchdown.vx_mps, 0.0);
  DOUBLES_EQUAL(a.touchdown.omega_radps, b.touchdown.omega_radps, 0.0);
  DOUBLES_EQUAL(a.coefficients.mu, b.coefficients.mu, 0.0);
  DOUBLES_EQUAL(a.equator_rad, b.equator_rad, 0.0);
}

TEST(SpatialPath, BouncesAgainWhereItIsAndAsItHasTurned) {
  Scene scene = scene_of(ContactLaw::ode);
  scene.bounce.count = 2;
  const BallPath path = path_of(scene, thrown_of(scene, 1.0, {0.0, 150.0, 100.0}));
  double again_s = path.dwell_s();
  while (!path.bounced_again(again_s)) again_s += 1e-5;
  const BallState before = path.at(again_s - 1e-5), after = path.at(again_s + 1e-5);
  // 20 us at 20 m/s and 600 rad/s.
  check_near(place_of(before), place_of(after), 5e-4, "place");
  check_turned(before.attitude(), after.attitude(), 0.02, "attitude");
  CHECK(after.z_m > 0.1);
}

TEST(SpatialPath, IsRefusedWhereAModelHasNoContactForIt) {
  const Scene scene = scene_of(ContactLaw::ode);
  const ShotConditions thrown = thrown_of(scene, 0.0, {0.0, 100.0, 0.0});
  CHECK(BallPath::make(scene, thrown).has_value());
  const auto path = BallPath::make(scene, thrown, Model::full().without(Effect::contact_ode));
  CHECK_FALSE(path.has_value());
  STRCMP_CONTAINS("out of the plane needs grip, tangential_compliance and contact_ode",
                  path.error().message.c_str());
}
