#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>
#include <rapidcheck.h>
#include <vector>

#include "common/attitude/attitude_spin.hpp"
#include "tests/support/property.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::attitude;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using testing::between;
using testing::holds_of_all;
using testing::Worst;

namespace {

constexpr double kPi = std::numbers::pi;

Vector3d drawn_vector(double length) {
  const double z = between(-1, 1), turn = between(0, 2 * kPi), flat = std::sqrt(1 - z * z);
  return length * Vector3d(flat * std::cos(turn), flat * std::sin(turn), z);
}

/// The truth in quaternions, which the fit does not use.
Matrix3d turned(const Vector3d& vector) {
  const double half = 0.5 * vector.norm();
  const double share = half > 0 ? std::sin(half) / (2 * half) : 0.5;
  return Quaterniond(std::cos(half), share * vector.x(), share * vector.y(), share * vector.z()).toRotationMatrix();
}

class Flight {
 public:
  explicit Flight(std::uint64_t seed) : random_(seed) {}

  std::vector<TimedAttitude> images(const std::vector<double>& times_s, double sd_rad) {
    std::vector<TimedAttitude> images;
    for (const double t : times_s) {
      const double s = decay > 0 ? (1 - std::exp(-decay * t)) / decay : t;
      const Matrix3d truth = turned(spin * s) * turned(wobble * t) * start;
      const Vector3d error(normal_(random_), normal_(random_), normal_(random_));
      images.push_back({t, turned(sd_rad * error) * truth, std::max(sd_rad, 1e-6) * std::max(sd_rad, 1e-6) * Matrix3d::Identity()});
    }
    return images;
  }

  Vector3d spin{20, -250, 90};
  Vector3d wobble = Vector3d::Zero();
  double decay = 0.0;
  Matrix3d start = turned({0.4, -1.1, 2.0});

 private:
  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

const std::vector<double> kUneven_s{0, 0.003, 0.0071, 0.0098, 0.0142, 0.0171, 0.0213};

}  // namespace

TEST_GROUP(AttitudeSpins){};

TEST(AttitudeSpins, RotationsAndTheirVectorsInvertEachOther) {
  CHECK(holds_of_all([](Worst& worst) {
    const Vector3d vector = drawn_vector(testing::sometimes(kPi - 1e-7, between(0, kPi - 1e-7)));
    const Matrix3d r = rotation(vector);
    RC_ASSERT(worst.within((r - turned(vector)).norm(), 1e-14 * 8));  // rounding of some ten operations
    // Of a turn by nearly pi the quaternion's w is small, but its rounding enters the angle as it is.
    RC_ASSERT(worst.within((rotation_vector_rad(r) - vector).norm(), 1e-13));
  }));
}

TEST(AttitudeSpins, ASpinWithoutNoiseIsFoundWhateverItsAxisAndTheAttitude) {
  CHECK(holds_of_all([](Worst& worst) {
    Flight flight(1);
    flight.spin = drawn_vector(between(0.1, 900));
    flight.start = turned(drawn_vector(between(0, kPi)));
    const auto fits = fit_spin(flight.images(kUneven_s, 0), {.fastest_spin_radps = 1000});
    RC_ASSERT(fits.has_value());
    // Stated sds of a microradian over 20 ms: 1e-4 rad/s would be two of them.
    RC_ASSERT(worst.within((fits->front().spin_radps - flight.spin).norm(), 1e-6));
  }));
}

// Turning the picture turns the spin; nothing else depends on where its axes point.
TEST(AttitudeSpins, TheFitTurnsWithTheAxes) {
  CHECK(holds_of_all([](Worst& worst) {
    Flight flight(7);
    const auto images = flight.images(kUneven_s, 0.01);
    auto other = images;
    const Matrix3d r = turned(drawn_vector(between(0, kPi)));
    for (TimedAttitude& one : other) one.attitude = r * one.attitude;
    const auto a = fit_spin(images, {.fastest_spin_radps = 1000}), b = fit_spin(other, {.fastest_spin_radps = 1000});
    RC_ASSERT(a && b);
    // Gauss-Newton stops at a millionth of an sd, which is some 2 rad/s.
    RC_ASSERT(worst.within((b->front().spin_radps - r * a->front().spin_radps).norm(), 1e-4));
  }));
}

// 100 flights of 7 attitudes: the mean of 300 squared standardized errors is 1 ± sqrt(2/300) = ± .082; 4 sd.
TEST(AttitudeSpins, ErrorsAreAsLargeAsStated) {
  constexpr int kFlights = 100;
  double sum = 0.0;
  for (int k = 0; k < kFlights; ++k) {
    Flight flight(static_cast<std::uint64_t>(k));
    const auto fits = fit_spin(flight.images(kUneven_s, 0.01), {.fastest_spin_radps = 1000});
    CHECK_TRUE(fits.has_value());
    const Vector3d error = fits->front().spin_radps - flight.spin;
    const double reduced = std::max(1.0, fits->front().chi_squared / fits->front().degrees_of_freedom);
    sum += error.dot((fits->front().covariance_radps2 / reduced).inverse() * error) / 3.0;
  }
  DOUBLES_EQUAL(1.0, sum / kFlights, 0.33);
}

TEST(AttitudeSpins, EvenTimesLeaveWholeTurnsOpenAndTheSlowestIsFirst) {
  Flight flight(3);
  flight.spin = {0, 0, 300};
  const auto fits = fit_spin(flight.images({0, 0.003, 0.006, 0.009}, 0.005), {.fastest_spin_radps = 4000});
  CHECK_TRUE(fits.has_value());
  // A turn more in 3 ms is 2094 rad/s more: 300, -1794, 2394, -3889.
  CHECK_EQUAL(4U, fits->size());
  DOUBLES_EQUAL(300, fits->front().spin_radps.z(), 5);
  DOUBLES_EQUAL(-1794.4, (*fits)[1].spin_radps.z(), 5);
  CHECK_EQUAL(1U, fit_spin(flight.images({0, 0.003, 0.006, 0.009}, 0.005), {.fastest_spin_radps = 1000})->size());
  CHECK_EQUAL(1U, fit_spin(flight.images({0, 0.003, 0.0071, 0.0098}, 0.005), {.fastest_spin_radps = 4000})->size());
}

TEST(AttitudeSpins, WrongAttitudesAreLeftOutAndNamed) {
  Flight flight(5);
  auto images = flight.images(kUneven_s, 0.01);
  images[2].attitude = turned({0.5, 0.9, 0}) * images[2].attitude;
  images[5].attitude = turned({0, 0, 2}) * images[5].attitude;
  const auto fits = fit_spin(images, {.fastest_spin_radps = 1000});
  CHECK_TRUE(fits.has_value());
  const SpinFit& fit = fits->front();
  CHECK_TRUE(fit.used == std::vector<bool>({true, true, false, true, true, false, true}));
  const Vector3d sd = fit.covariance_radps2.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) CHECK_TRUE(std::abs(fit.spin_radps[i] - flight.spin[i]) < 4 * sd[i]);
}

TEST(AttitudeSpins, DecayAndWobbleAreFoundWhereTheyMayBe) {
  Flight flight(9);
  flight.decay = 0.4;
  flight.wobble = Vector3d(3, 1, 0) - flight.spin * flight.spin.dot(Vector3d(3, 1, 0)) / flight.spin.squaredNorm();
  std::vector<double> times_s;
  for (int k = 0; k < 25; ++k) times_s.push_back(0.00262 * k);
  const auto images = flight.images(times_s, 0.005);
  const auto fits = fit_spin(images, {.fastest_spin_radps = 1000, .decay_sd_per_s = 0.5, .wobble_sd = 0.02});
  CHECK_TRUE(fits.has_value());
  const SpinFit& fit = fits->front();
  CHECK_TRUE(std::abs(fit.decay_per_s - 0.4) < 4 * fit.decay_sd_per_s);
  CHECK_TRUE(fit.decay_sd_per_s < 0.1);
  // Fixed in the ball: compared there, at the first image.
  const Vector3d wobble = fit.attitude.transpose() * fit.wobble_radps;
  const Vector3d truth = flight.start.transpose() * flight.wobble;
  CHECK_TRUE((wobble - truth).norm() < 4 * std::sqrt(fit.wobble_covariance_radps2.trace()));
  CHECK_TRUE(std::sqrt(fit.wobble_covariance_radps2.trace()) < 0.3);
  for (const TimedAttitude& one : images)
    CHECK_TRUE(rotation_vector_rad(one.attitude * fit.attitude_at(one.time_s).transpose()).norm() < 0.005 * 5);
  // Without them the same attitudes scatter more than they may.
  const auto plain = fit_spin(images, {.fastest_spin_radps = 1000});
  CHECK_TRUE(plain && plain->front().chi_squared > 3 * plain->front().degrees_of_freedom);
}

TEST(AttitudeSpins, WhatCannotBeFittedIsAnError) {
  Flight flight(1);
  auto images = flight.images(kUneven_s, 0.01);
  const auto error = [](std::span<const TimedAttitude> given, double fastest) {
    const auto fits = fit_spin(given, {.fastest_spin_radps = fastest});
    return fits ? std::string() : fits.error().message;
  };
  CHECK_EQUAL(std::string("the fastest spin must be above 0 rad/s"), error(images, 0));
  CHECK_EQUAL(std::string("1 attitude: a spin needs two or more"), error(std::span(images).first(1), 1000));
  CHECK_EQUAL(std::string("no two attitudes agree with a spin up to 1 rad/s"), error(images, 1));
  images[1].time_s = images[0].time_s;
  CHECK_EQUAL(std::string("two attitudes are of the same time"), error(images, 1000));
  images[1].time_s = NAN;
  CHECK_EQUAL(std::string("an attitude is not finite, or its covariance not positive definite"), error(images, 1000));
}
