#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "common/attitude/line_spin.hpp"
#include "common/units/angles.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::attitude;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kSd = 0.002;  // 0.11 degrees, of angles and tilts

/// A ball that spins, seen by a pinhole: written from the geometry alone, by quaternions and projected points.
struct Ball {
  Vector3d omega_radps = {0.0, 0.0, 300.0};
  Vector3d normal = {0.0, 1.0, 0.0};  // of its line's plane at time 0
  Vector3d centre_m = Vector3d::Zero();
  double lens_m = 1e6;
  double decay_per_s = 0.0;

  Vector3d normal_at(double time) const {
    // Steps of a microsecond's thousandth part of a turn.
    constexpr int kSteps = 2000;
    Eigen::Quaterniond attitude = Eigen::Quaterniond::Identity();
    for (int i = 0; i < kSteps; ++i) {
      const double middle = time * (i + 0.5) / kSteps;
      const double angle = omega_radps.norm() * std::exp(-decay_per_s * middle) * time / kSteps;
      attitude = Eigen::Quaterniond(Eigen::AngleAxisd(angle, omega_radps.normalized())) * attitude;
    }
    return attitude * normal;
  }

  LineReading seen(double time, std::mt19937_64& random, double noise = 1.0) const {
    const Vector3d n = normal_at(time);
    const Vector3d to_lens = (Vector3d(0.0, 0.0, lens_m) - centre_m).normalized();
    // The line's ends on the outline, a small ball's, through the lens.
    const Vector3d along = n.cross(to_lens).normalized();
    const auto project = [&](const Vector3d& p) { return Vector2d(p.head<2>() * (lens_m / (lens_m - p.z()))); };
    const Vector2d chord = project(centre_m + 1e-5 * along) - project(centre_m - 1e-5 * along);
    std::normal_distribution<double> normal_draw(0.0, noise * kSd);
    LineReading r;
    r.time_s = time;
    r.tilt_rad = -std::asin(n.dot(to_lens));
    r.tilt_sd_rad = kSd;
    // What is known of the chord's angle grows uncertain as the line becomes a ring.
    r.angle_sd_rad = kSd / std::cos(r.tilt_rad);
    r.angle_rad = std::atan2(chord.y(), chord.x()) + normal_draw(random) / std::cos(r.tilt_rad);
    r.tilt_rad += normal_draw(random);
    r.sight = (Vector2d::Zero() - centre_m.head<2>()) / (lens_m - centre_m.z());
    // The same plane seen the other way round.
    if (random() % 2 == 0) {
      r.angle_rad += kPi;
      r.tilt_rad = -r.tilt_rad;
    }
    return r;
  }

  std::vector<LineReading> images(int count, std::mt19937_64& random, double noise = 1.0) const {
    // Coded steps of some 3 ms.
    constexpr std::array kCode_s{0.0, 2.8e-3, 6.1e-3, 8.7e-3, 12.1e-3, 15.2e-3};
    std::vector<LineReading> all;
    for (int i = 0; i < count; ++i) all.push_back(seen(kCode_s[static_cast<std::size_t>(i)], random, noise));
    return all;
  }
};

Vector3d drawn_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vector3d(normal(random), normal(random), normal(random)).normalized();
}

/// A ball with its axis so far off the camera's, and a line along it but for up to 2 degrees.
Ball drawn_ball(double tilt_rad, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Ball ball;
  const double azimuth = kPi * unit(random), rate = 100.0 + 400.0 * std::abs(unit(random));
  const Vector3d axis(std::sin(tilt_rad) * std::cos(azimuth), std::sin(tilt_rad) * std::sin(azimuth),
                      std::cos(tilt_rad));
  ball.omega_radps = (unit(random) < 0.0 ? -rate : rate) * axis;
  ball.normal = (axis.unitOrthogonal() + 0.035 * drawn_direction(random)).normalized();
  ball.normal = Eigen::AngleAxisd(kPi * unit(random), axis) * ball.normal;
  ball.lens_m = 1.5;
  ball.centre_m = {0.15 * unit(random), 0.1 * unit(random), 0.02 * unit(random)};
  return ball;
}

constexpr SpinLimits kTennis{650.0, 0.0};

}  // namespace

TEST_GROUP(LineSpinFit){std::mt19937_64 random{1};};

TEST(LineSpinFit, IsExactWithoutNoiseAtEveryTiltOfTheAxis) {
  for (const double tilt : {0.0, 0.1, 0.5, 1.0, 1.5}) {
    for (int i = 0; i < 20; ++i) {
      const Ball ball = drawn_ball(tilt, random);
      const auto fit = fit_line_spin(ball.images(5, random, 0.0), kTennis);
      CHECK_TRUE(fit.has_value());
      // The prior draws a spin of 500 rad/s known to .5 by the square of .5/650 of it.
      DOUBLES_EQUAL(0.0, (fit->omega_radps - ball.omega_radps).norm(), 3e-4);
    }
  }
}

TEST(LineSpinFit, ErrorsAreAsLargeAsTheCovarianceSays) {
  for (const double tilt : {0.05, 0.8}) {
    constexpr int kBalls = 400;
    double square = 0.0, chi_squared = 0.0;
    for (int i = 0; i < kBalls; ++i) {
      const Ball ball = drawn_ball(tilt, random);
      const auto fit = fit_line_spin(ball.images(5, random), kTennis);
      CHECK_TRUE(fit.has_value());
      const Vector3d error = fit->omega_radps - ball.omega_radps;
      square += error.dot(fit->covariance.inverse() * error) / 3.0;
      chi_squared += fit->chi_squared / 5.0;
    }
    // 1200 squares: their mean scatters by sqrt(2/1200) = .041; 2000 in chi squared: .032. Four sd.
    DOUBLES_EQUAL(1.0, square / kBalls, 0.164);
    DOUBLES_EQUAL(1.0, chi_squared / kBalls, 0.126);
  }
}

TEST(LineSpinFit, ThreeImagesSuffice) {
  const Ball ball = drawn_ball(0.6, random);
  const auto fit = fit_line_spin(ball.images(3, random), kTennis);
  CHECK_TRUE(fit.has_value());
  const Vector3d error = fit->omega_radps - ball.omega_radps;
  // Chi squared of three degrees of freedom, once in a million by chance: 30.7.
  CHECK_TRUE(error.dot(fit->covariance.inverse() * error) < 30.7);
  CHECK_FALSE(fit_line_spin(ball.images(2, random), kTennis).has_value());
}

TEST(LineSpinFit, AllowsForTheSpinsDecay) {
  Ball ball = drawn_ball(0.7, random);
  ball.decay_per_s = 5.0;
  const auto fit = fit_line_spin(ball.images(5, random, 0.0), {650.0, 5.0});
  CHECK_TRUE(fit.has_value());
  const Vector3d then = ball.omega_radps * std::exp(-5.0 * fit->time_s);
  // The prior's share, as above; two thousand steps of the decay by their middles are off by 1e-10 of the turn.
  DOUBLES_EQUAL(0.0, (fit->omega_radps - then).norm(), 3e-4);
}

TEST(LineSpinFit, LeavesOutOneReadingThatDoesNotBelong) {
  const Ball ball = drawn_ball(0.5, random);
  auto images = ball.images(6, random);
  images[2].tilt_rad += 0.2;
  const auto fit = fit_line_spin(images, kTennis);
  CHECK_TRUE(fit.has_value());
  CHECK_EQUAL(1, fit->left_out.size());
  CHECK_EQUAL(2, fit->left_out.front());
  images[4].angle_rad += 0.5;
  CHECK_FALSE(fit_line_spin(images, kTennis).has_value());
}

TEST(LineSpinFit, TellsOtherSpinsThatAnEvenTrainLeavesOpen) {
  Ball ball;
  ball.omega_radps = Vector3d(0.0, 0.3, 1.0).normalized() * 300.0;
  ball.normal = Vector3d(1.0, 0.0, 0.0);
  std::vector<LineReading> images;
  for (int i = 0; i < 5; ++i) images.push_back(ball.seen(3e-3 * i, random));
  CHECK_TRUE(fit_line_spin(images, {650.0, 0.0})->alternatives_radps.empty());
  // A plane square to the axis' plane: half a turn less in 3 ms, 300 - 1047 rad/s, looks alike.
  const auto fit = fit_line_spin(images, {800.0, 0.0});
  CHECK_EQUAL(1, fit->alternatives_radps.size());
  DOUBLES_EQUAL(kPi / 3e-3 - 300.0, fit->alternatives_radps.front().norm(), 5.0);
}

TEST(LineSpinFit, ATurnAboutTheLinesOwnNormalIsNotTold) {
  Ball ball;
  ball.omega_radps = Vector3d(0.0, 200.0, 100.0);
  ball.normal = ball.omega_radps.normalized();
  const auto fit = fit_line_spin(ball.images(5, random), kTennis);
  // It may be any along the normal: the sd is as large as all that is looked for, or it is not fitted at all.
  CHECK_TRUE(!fit || std::sqrt(fit->normal.dot(fit->covariance * fit->normal)) > 650.0 || !fit->alternatives_radps.empty());
}

TEST_GROUP(PlanarSpinTest){std::mt19937_64 random{2};};

namespace {

/// Readings whose angles go on and on, of a spin about an axis near the camera's.
std::vector<LineReading> along_the_spin(const Ball& ball, std::mt19937_64& random) {
  auto images = ball.images(6, random);
  for (std::size_t i = 1; i < images.size(); ++i) {
    const double expected =
        images[i - 1].angle_rad + ball.omega_radps.z() * (images[i].time_s - images[i - 1].time_s);
    const double turns = std::round((expected - images[i].angle_rad) / kPi);
    images[i].angle_rad += kPi * turns;
    if (std::fmod(std::abs(turns), 2.0) == 1.0) images[i].tilt_rad = -images[i].tilt_rad;
  }
  return images;
}

}  // namespace

TEST(PlanarSpinTest, PassesSpinsAboutTheCamerasAxisWhateverTheLine) {
  double gain = 0.0;
  constexpr int kBalls = 400;
  for (int i = 0; i < kBalls; ++i) {
    Ball ball = drawn_ball(0.0, random);
    ball.lens_m = 1e6;
    gain += test_planar(along_the_spin(ball, random))->chi_squared_gain / 2.0;
  }
  // Chi squared over its two degrees of freedom scatters by sqrt(2/800); four sd.
  DOUBLES_EQUAL(1.0, gain / kBalls, 0.2);
}

TEST(PlanarSpinTest, SmallTiltsComeOutToTheFirstOrder) {
  for (int i = 0; i < 100; ++i) {
    Ball ball = drawn_ball(0.04, random);
    ball.lens_m = 1e6;
    const auto test = test_planar(along_the_spin(ball, random));
    const Vector2d truth = ball.omega_radps.head<2>() / ball.omega_radps.z();
    const Vector2d error = test->ratio - truth;
    // Second order: the square of .04 and of the line's own 2 degrees, some .002; with four sd of noise.
    const double sd = std::sqrt(test->ratio_covariance.trace());
    CHECK_TRUE(error.norm() < 0.004 + 5.0 * sd);
  }
}

TEST_GROUP(LinePlane){};

TEST(LinePlane, IsTheSameForTheOppositeDirection) {
  const Vector2d sight(0.1, -0.05);
  const auto one = line_plane(0.7, 0.3, sight);
  const auto other = line_plane(0.7 + kPi, -0.3, sight);
  DOUBLES_EQUAL(0.0, (one.normal + other.normal).norm(), 1e-15);
  DOUBLES_EQUAL(0.7, line_angle_rad(one.normal, sight), 1e-14);
}
