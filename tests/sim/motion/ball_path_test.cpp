#include "sim/motion/ball_path.hpp"

#include <fmt/format.h>

#include <cmath>

#include "sim/rig/truth.hpp"
#include "tests/sim/rig/virtual_rig_fixture.hpp"

#include <CppUTest/TestHarness.h>

namespace {

using namespace strobe;
using namespace strobe::sim;
using reduction::Quantity;

constexpr int kKinds = 7;  // of each law
constexpr int kShots = 60;

/// A scene with every spread on, of a few rebounds that differ much.
Scene spread_scene(int kind) {
  Scene scene = test::plain_scene();
  scene.machine.angle_rad = -(15.0 + 9.0 * (kind % kKinds)) * std::numbers::pi / 180.0;
  scene.machine.spin_radps = 90.0 * (kind % 5 - 2);
  scene.machine.speed_sd_mps = 1.0;
  scene.machine.angle_sd_rad = 0.04;
  scene.machine.spin_sd_radps = 20.0;
  scene.bounce.e_speed_mps = 10.0;
  scene.bounce.e_sd = 0.03;
  scene.bounce.mu_sd = 0.05;
  scene.bounce.ex_sd = 0.1;
  scene.bounce.offset_sd_m = 0.001;
  scene.bounce.offset_share_sd = 0.03;
  scene.bounce.dwell_sd_s = 0.0003;
  scene.bounce.contact = kind < kKinds ? ContactLaw::ode : ContactLaw::grip;
  scene.surface_angle_rad = kind % 2 == 0 ? 0.0 : 0.3;
  return scene;
}

template <typename Check>
void for_many_balls(Check check) {
  for (int kind = 0; kind < 2 * kKinds; ++kind) {
    const Scene scene = spread_scene(kind);
    for (int shot = 1; shot <= kShots; ++shot) {
      const ShotConditions thrown = draw_shot_conditions(scene, 99, shot);
      const auto path = BallPath::make(scene, thrown);
      CHECK_TEXT(path.has_value(), fmt::format("kind {} shot {}", kind, shot).c_str());
      check(scene, thrown, *path);
    }
  }
}

double tangential_energy(const Scene& scene, const impact::Motion& m) {
  const double rim = scene.ball.radius_m() * m.omega_radps;
  return m.vx_mps * m.vx_mps + scene.ball.alpha * rim * rim;
}

}  // namespace

TEST_GROUP(BallPath){};

TEST(BallPath, TouchesDownAndLiftsOffWithItsCentreOneRadiusUp) {
  for_many_balls([](const Scene& scene, const ShotConditions&, const BallPath& path) {
    DOUBLES_EQUAL(scene.ball.radius_m(), path.at(0.0).y_m, 1e-15);
    DOUBLES_EQUAL(scene.ball.radius_m(), path.at(path.dwell_s()).y_m, 1e-12);
    DOUBLES_EQUAL(0.0, path.at(0.0).x_m, 1e-15);
    DOUBLES_EQUAL(path.dwell_distance_m(), path.at(path.dwell_s()).x_m, 1e-15);
  });
}

TEST(BallPath, IsBelowItsRadiusThroughoutTheDwellTimeAndOnlyThen) {
  for_many_balls([](const Scene& scene, const ShotConditions&, const BallPath& path) {
    for (int i = 1; i < 100; ++i) {
      const BallState s = path.at(path.dwell_s() * i / 100.0);
      CHECK(s.y_m < scene.ball.radius_m());
      CHECK(s.top_drop_m > 0.0);
    }
    for (const double before_s : {-1e-6, -1e-3, -0.01}) CHECK(path.at(before_s).y_m > scene.ball.radius_m());
    for (const double after_s : {1e-6, 1e-3, 0.01})
      CHECK(path.at(path.dwell_s() + after_s).y_m > scene.ball.radius_m());
  });
}

TEST(BallPath, MovesAsItsVelocitiesSay) {
  // Central differences: the third derivative is at most v·(pi/dwell)² (damping adds less than as much
  // again), the error h²/6 of it: 60·2·(pi/3e-3)²·1e-12/6 < 3e-5 m/s; for the spin likewise with 400 rad/s.
  constexpr double h = 1e-6;
  for_many_balls([](const Scene&, const ShotConditions&, const BallPath& path) {
    for (int i = -10; i <= 20; ++i) {
      const double t = path.dwell_s() * (i + 0.37) / 10.0;
      const BallState a = path.at(t - h);
      const BallState b = path.at(t + h);
      const BallState s = path.at(t);
      DOUBLES_EQUAL(s.vx_mps, (b.x_m - a.x_m) / (2 * h), 1e-4);
      DOUBLES_EQUAL(s.vy_mps, (b.y_m - a.y_m) / (2 * h), 1e-4);
      DOUBLES_EQUAL(s.omega_radps, (b.equator_rad - a.equator_rad) / (2 * h), 1e-3);
    }
  });
}

TEST(BallPath, HasNoJumpInPlaceVelocityOrSpin) {
  for_many_balls([](const Scene&, const ShotConditions&, const BallPath& path) {
    for (const double t : {0.0, path.dwell_s()}) {
      const BallState a = path.at(t - 1e-9);
      const BallState b = path.at(t + 1e-9);
      DOUBLES_EQUAL(a.x_m, b.x_m, 1e-7);
      DOUBLES_EQUAL(a.y_m, b.y_m, 1e-7);
      DOUBLES_EQUAL(a.vx_mps, b.vx_mps, 1e-4);
      DOUBLES_EQUAL(a.vy_mps, b.vy_mps, 1e-4);
      DOUBLES_EQUAL(a.omega_radps, b.omega_radps, 1e-3);
      DOUBLES_EQUAL(a.equator_rad, b.equator_rad, 1e-5);
    }
  });
}

TEST(BallPath, MeetsTheSurfaceAsOftenAsTheSceneSays) {
  Scene scene = test::plain_scene();
  scene.machine.speed_mps = 2.0;
  scene.machine.angle_rad = -1.0;
  scene.bounce.count = 3;
  const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
  const double radius_m = scene.ball.radius_m();
  int contacts = 0;
  bool touches = false;
  double t = 0.0, last_m = 0.0;
  for (; !path->beyond_last_bounce(t, path->at(t)); t += 1e-4) {
    const BallState s = path->at(t);
    CHECK_EQUAL(s.y_m < radius_m && t > 0.0, s.top_drop_m > 0.0);
    contacts += s.top_drop_m > 0.0 && !touches ? 1 : 0;
    touches = s.top_drop_m > 0.0;
    CHECK_EQUAL(contacts > 1, path->bounced_again(t));
    CHECK(s.x_m >= last_m);
    last_m = s.x_m;
    const BallState before = path->at(t - 1e-9), after = path->at(t + 1e-9);
    // 4 m/s for 2 ns; a contact's 600 m/s² for as long.
    DOUBLES_EQUAL(before.x_m, after.x_m, 1e-8);
    DOUBLES_EQUAL(before.y_m, after.y_m, 1e-8);
    DOUBLES_EQUAL(before.vy_mps, after.vy_mps, 2e-6);
    DOUBLES_EQUAL(std::remainder(before.equator_rad - after.equator_rad, std::numbers::pi), 0.0, 1e-6);
  }
  LONGS_EQUAL(3, contacts);
  scene.bounce.count = 1;
  const auto first = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
  DOUBLES_EQUAL(first->at(0.05).y_m, path->at(0.05).y_m, 0.0);
  CHECK(!first->bounced_again(1.0));
}

TEST(BallPath, TurnsFrictionIntoSpinByTheMomentEquation) {
  // alpha·R²·Δomega = R·Δvx + d·J with the offset that acted, Δvx being friction's; the ODE has the weight along the
  // plate besides.
  for_many_balls([](const Scene& scene, const ShotConditions& thrown, const BallPath& path) {
    const impact::Motion& td = thrown.touchdown;
    const impact::Motion& lo = path.rebound().lift_off;
    const double r = scene.ball.radius_m(), impulse = lo.vy_mps - td.vy_mps;
    const bool ode = scene.bounce.contact == ContactLaw::ode;
    const double pull_mps = ode ? -9.80665 * std::sin(scene.surface_angle_rad) * path.dwell_s() : 0.0;
    DOUBLES_EQUAL(scene.ball.alpha * r * r * (lo.omega_radps - td.omega_radps),
                  r * (lo.vx_mps - td.vx_mps - pull_mps) + path.rebound().offset_m * impulse, 1e-12);
    // The weight makes the contact deeper and so takes a little more, in the ODE's law.
    DOUBLES_EQUAL(-thrown.coefficients.e * td.vy_mps, lo.vy_mps, ode ? 0.01 : 1e-12);
  });
}

TEST(BallPath, NeverGainsEnergyInTheImpact) {
  for_many_balls([](const Scene& scene, const ShotConditions& thrown, const BallPath& path) {
    const double before = tangential_energy(scene, thrown.touchdown);
    CHECK(tangential_energy(scene, path.rebound().lift_off) <= before * (1.0 + 1e-12));
    CHECK(std::abs(path.rebound().lift_off.vy_mps) < std::abs(thrown.touchdown.vy_mps));
  });
}

TEST(BallPath, PassesTheGateWhereTheGateStands) {
  for_many_balls([](const Scene&, const ShotConditions&, const BallPath& path) {
    for (const double distance_m : {0.2, 1.0, 3.0}) {
      const auto t = path.time_at_distance_s(distance_m);
      CHECK(t && *t < 0.0);
      DOUBLES_EQUAL(-distance_m, path.at(*t).x_m, 1e-9);
    }
  });
}

TEST(BallPath, NeverPassesAGateThatItsFlightCannotHaveComeFrom) {
  // Down a steep plate, against the fall: the ball reached 1.3 m/s only within the last decimetre or so.
  Scene scene = test::plain_scene();
  scene.surface_angle_rad = -1.0;
  scene.machine.speed_mps = 1.3;
  const auto path = BallPath::make(scene, draw_shot_conditions(scene, 1, 1));
  CHECK(!path->time_at_distance_s(3.0));
}

TEST(BallPath, TellsTheTruthThatItsOwnStatesShow) {
  for_many_balls([](const Scene& scene, const ShotConditions&, const BallPath& path) {
    const reduction::Quantities q = true_readout(scene, path);
    const BallState td = path.at(0.0);
    const BallState lo = path.at(path.dwell_s());
    DOUBLES_EQUAL(td.vx_mps, *q[Quantity::vx_td_mps], 1e-9);
    DOUBLES_EQUAL(lo.vx_mps, *q[Quantity::vx_lo_mps], 1e-9);
    DOUBLES_EQUAL(lo.vy_mps, *q[Quantity::vy_lo_mps], 1e-9);
    DOUBLES_EQUAL(lo.omega_radps, *q[Quantity::omega_lo_radps], 1e-9);
    DOUBLES_EQUAL(lo.vx_mps + scene.ball.radius_m() * lo.omega_radps, *q[Quantity::slip_lo_mps], 1e-9);
    DOUBLES_EQUAL(-lo.vy_mps / td.vy_mps, *q[Quantity::e], 1e-9);
    DOUBLES_EQUAL((td.vx_mps - lo.vx_mps) / (lo.vy_mps - td.vy_mps), *q[Quantity::mu], 1e-9);
    DOUBLES_EQUAL(100.0 * (lo.x_m - td.x_m), *q[Quantity::dwell_distance_cm], 1e-9);
    DOUBLES_EQUAL(1000.0 * path.dwell_s(), *q[Quantity::dwell_time_ms], 1e-12);
  });
}

TEST(BallPath, DoesNotDependOnEarlierShots) {
  const Scene scene = spread_scene(3);
  const ShotConditions direct = draw_shot_conditions(scene, 5, 40);
  for (int shot = 1; shot < 40; ++shot) draw_shot_conditions(scene, 5, shot);
  DOUBLES_EQUAL(direct.touchdown.vx_mps, draw_shot_conditions(scene, 5, 40).touchdown.vx_mps, 0.0);
}

TEST(BallPath, LosesRestitutionWithSpeedAsTheSceneSays) {
  Scene scene = test::plain_scene();
  const double e0 = draw_shot_conditions(scene, 1, 1).coefficients.e;
  scene.machine.speed_mps = 27.0;
  const double more = (27.0 - 17.0) * std::sin(23.0 * std::numbers::pi / 180.0);
  DOUBLES_EQUAL(e0 - 0.017 * more, draw_shot_conditions(scene, 1, 1).coefficients.e, 1e-12);
}

TEST(BallPath, GivesTheCourtPaceOfTheStandardsExamples) {
  // ITF CS 01/02: (mu .63, e .81) gives 37, (.53, .75) gives 56, at 23 degrees Celsius. A sliding ball that
  // starts without spin keeps exactly mu.
  Scene scene = test::plain_scene();
  scene.air.temperature_c = 23.0;
  scene.bounce.contact = ContactLaw::grip;
  scene.bounce.offset_m = 0.0;
  scene.machine.angle_rad = -10.0 * std::numbers::pi / 180.0;
  scene.bounce.e_slope_spm = 0.0;
  const auto pace = [&](double mu, double e) {
    scene.bounce.mu = mu;
    scene.bounce.e = e;
    return *true_readout(scene,
                         *BallPath::make(scene, draw_shot_conditions(scene, 1, 1)))[Quantity::court_pace];
  };
  DOUBLES_EQUAL(37.0, pace(0.63, 0.81), 1e-9);
  DOUBLES_EQUAL(56.0, pace(0.53, 0.75), 1e-9);
}
