// The joint covariance of velocities, spins and instants against the scatter of simulated shots.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#include "common/reduction/propagate.hpp"
#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/simulated_shot.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;
using test::Bounce;
using test::Setup;

namespace {

std::uint64_t seed() { return test::seed_or(977); }

using Vector8 = Eigen::Matrix<double, 8, 1>;
using Matrix8 = Eigen::Matrix<double, 8, 8>;

Matrix8 matrix(const PrimaryCovariance& covariance) {
  Matrix8 m;
  for (int i = 0; i < 8; ++i)
    for (int k = 0; k < 8; ++k)
      m(i, k) = covariance[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  return m;
}

Readout reduced_shot(const Frame& frame) { return *reduce(frame, Estimator::best, {.covariance = true}); }

constexpr Quantity kVelocities[] = {Quantity::vx_td_mps, Quantity::vy_td_mps, Quantity::omega_td_radps,
                                    Quantity::vx_lo_mps, Quantity::vy_lo_mps, Quantity::omega_lo_radps};
constexpr int kVelocityIndex[] = {0, 1, 2, 4, 5, 6};

}  // namespace

TEST_GROUP(JointCovariance) {
  test::Random random{seed()};
  void setup() override {
    std::printf("(seed %llu: repeat with STROBE_SEED)", static_cast<unsigned long long>(seed()));
  }
};

TEST(JointCovariance, IsGivenOnlyWhenAskedForAndWhole) {
  Frame frame = test::photograph(Bounce{}, Setup{}, random);
  CHECK_FALSE(reduce(frame, Estimator::best)->covariance.has_value());
  CHECK_TRUE(reduced_shot(frame).covariance.has_value());
  for (BallImage& image : frame.images) {
    if (image.leg == Leg::rebound) image.equator_rad.reset();
  }
  CHECK_FALSE(reduced_shot(frame).covariance.has_value());
}

TEST(JointCovariance, HasTheReadoutsSdOnItsDiagonalAndExplainsTheRatios) {
  Frame frame = test::photograph(Bounce{}, Setup{}, random);
  frame.temperature_c = 20.0;
  const Readout r = reduced_shot(frame);
  const Matrix8 m = matrix(*r.covariance);
  for (int i = 0; i < 6; ++i) {
    const double sd = *r.sd[kVelocities[i]];
    DOUBLES_EQUAL(sd, std::sqrt(m(kVelocityIndex[i], kVelocityIndex[i])), 1e-9 * sd);
  }
  // Dwell time is the difference of the instants; e and mu follow from the velocities: the delta method on
  // the printed formulas must give their sd. Rounding of a few operations, cancelling thousandfold at most.
  Vector8 dwell = Vector8::Zero();
  dwell(7) = 1e3, dwell(3) = -1e3;
  const auto sd = [&](const Vector8& g) { return std::sqrt(g.dot(m * g)); };
  DOUBLES_EQUAL(*r.sd[Quantity::dwell_time_ms], sd(dwell), 1e-9);
  const double vx = *r.value[Quantity::vx_td_mps], vy = *r.value[Quantity::vy_td_mps];
  const double ux = *r.value[Quantity::vx_lo_mps], uy = *r.value[Quantity::vy_lo_mps];
  Vector8 e = Vector8::Zero();
  e(1) = uy / (vy * vy), e(5) = -1.0 / vy;
  DOUBLES_EQUAL(*r.sd[Quantity::e], sd(e), 1e-10);
  Vector8 mu = Vector8::Zero();
  const double sum = uy - vy;
  mu(0) = 1.0 / sum, mu(4) = -1.0 / sum, mu(5) = -(vx - ux) / (sum * sum), mu(1) = (vx - ux) / (sum * sum);
  DOUBLES_EQUAL(*r.sd[Quantity::mu], sd(mu), 1e-10);
  const Vector8 pace = -100.0 * mu - 150.0 * e;  // e and mu err together
  DOUBLES_EQUAL(*r.sd[Quantity::court_pace], sd(pace), 1e-8);
}

TEST(JointCovariance, GivesEveryNumberTheSdOfItsNumericalDerivatives) {
  Frame frame = test::photograph(Bounce{}, Setup{}, random);
  frame.air_density_kgpm3 = 50.0;  // the velocity's part in the drag shows
  FlagSet flags;
  ShotFit fit = fit_shot(*observe(frame, flags), {}, flags);
  fit.spin_decay_per_m = 0.0;
  const auto velocity = [](const JointFit& joint, std::size_t leg) -> Eigen::Vector2d {
    const double* z = &joint.unknowns[kLegStart[leg]];
    return geometry::Rotation2d(joint.unknowns[kTilt]).inverse() * Eigen::Vector2d(z[2], z[3]) /
           (joint.unknowns[kScale] * joint.legs[leg].span_s);
  };
  const auto values = [&](std::size_t unknown, double step) {
    ShotFit moved = fit;
    if (unknown < kJointCount)
      moved.joint.unknowns[unknown] += step;
    else
      moved.spin[unknown - kJointCount]->omega_radps += step;
    for (std::size_t leg = 0; leg < 2; ++leg) {
      auto& forcing = moved.joint.forcing[leg];
      forcing.acceleration_mps2 +=
          forcing.by_velocity_per_s * (velocity(moved.joint, leg) - velocity(fit.joint, leg));
    }
    Readout readout;
    propagate(moved, {.temperature_c = 20.0}, readout);
    return readout.value;
  };
  Readout readout;
  propagate(fit, {.temperature_c = 20.0}, readout);
  std::array<Quantities, kJointCount + 2> derivative;
  for (std::size_t i = 0; i < kJointCount + 2; ++i) {
    const double step = i < kJointCount ? 1e-5 : 1e-2;  // of unknowns of order one, and of spins
    const Quantities more = values(i, step), less = values(i, -step);
    for (std::size_t k = 0; k < kQuantityCount; ++k) {
      const auto q = static_cast<Quantity>(k);
      derivative[i][q] = (*more[q] - *less[q]) / (2.0 * step);
    }
  }
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    const auto q = static_cast<Quantity>(k);
    JointVector gradient;
    for (std::size_t i = 0; i < kJointCount; ++i) gradient[i] = *derivative[i][q];
    double variance = 0.0;
    for (const double part : fit.joint.factor.whitened(gradient)) variance += part * part;
    for (std::size_t leg = 0; leg < 2; ++leg)
      variance += std::pow(*derivative[kJointCount + leg][q], 2) * fit.spin[leg]->variance;
    // Differences of numbers of 300 at most, rounded to 1e-13, over 2e-5: 1e-8 beside sds of 1e-3 and more.
    DOUBLES_EQUAL_TEXT(std::sqrt(variance), *readout.sd[q], 1e-5 * *readout.sd[q], kQuantityNames[k].data());
  }
}

TEST(JointCovariance, OfTheMirrorImageIsTheSame) {
  Setup setup;
  const Readout right = reduced_shot(test::photograph(Bounce{}, setup, random));
  setup.mirror = true;
  random.seed(seed());
  const Readout left = reduced_shot(test::photograph(Bounce{}, setup, random));
  const Matrix8 a = matrix(*right.covariance), b = matrix(*left.covariance);
  const Vector8 scale = a.diagonal().cwiseSqrt().cwiseInverse();
  // Correlations, to the rounding of the fit.
  DOUBLES_EQUAL(0.0, (scale.asDiagonal() * (a - b) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(JointCovariance, NormalizedErrorsOfTheVelocitiesAreChiSquared) {
  // Six velocities and spins; their errors together, in units of their covariance, have six degrees of
  // freedom: mean 6, and 10.645 and 16.812 are passed by 10 % and 1 % (tables). 20,000 shots know the mean
  // to sqrt(12 / 20000) = 0.024, the shares to 0.2 % and 0.07 %; four of those each, and as much again for
  // the second order of the angle between photograph and surface.
  const auto bounces = test::thesis_bounces();
  constexpr int kShots = 20000;
  double sum = 0.0;
  int beyond_10 = 0, beyond_1 = 0;
  for (int shot = 0; shot < kShots; ++shot) {
    const Bounce& bounce = bounces[static_cast<std::size_t>(shot) % bounces.size()];
    Setup setup;
    setup.phase = std::uniform_real_distribution<double>(0.0, 1.0)(random);
    const Readout r = reduced_shot(test::photograph(bounce, setup, random));
    CHECK_TRUE(r.covariance.has_value());
    const Quantities truth = test::truth(bounce);
    const Matrix8 whole = matrix(*r.covariance);
    Eigen::Matrix<double, 6, 1> error;
    Eigen::Matrix<double, 6, 6> covariance;
    for (int i = 0; i < 6; ++i) {
      error(i) = *r.value[kVelocities[i]] - *truth[kVelocities[i]];
      for (int k = 0; k < 6; ++k) covariance(i, k) = whole(kVelocityIndex[i], kVelocityIndex[k]);
    }
    const double chi = error.dot(covariance.ldlt().solve(error));
    sum += chi;
    if (chi > 10.645) ++beyond_10;
    if (chi > 16.812) ++beyond_1;
  }
  std::printf("(mean %.4f of 6, beyond 10 %%: %.4f, beyond 1 %%: %.4f)", sum / kShots,
              static_cast<double>(beyond_10) / kShots, static_cast<double>(beyond_1) / kShots);
  DOUBLES_EQUAL(6.0, sum / kShots, 0.2);
  DOUBLES_EQUAL(0.10, static_cast<double>(beyond_10) / kShots, 0.016);
  DOUBLES_EQUAL(0.01, static_cast<double>(beyond_1) / kShots, 0.0056);
}
