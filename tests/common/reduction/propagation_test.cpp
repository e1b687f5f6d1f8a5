// The joint covariance of velocities, spins and instants against the scatter of simulated shots.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "common/reduction/propagate.hpp"
#include "common/reduction/reduce.hpp"
#include "tests/common/reduction/reduced_frames.hpp"
#include "tests/common/reduction/simulated_shot.hpp"
#include "tests/support/repetitions.hpp"
#include "tests/support/string_from.hpp"

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

// What the errors of the camera's map do to a readout.
using namespace strobe::test;

namespace {

constexpr double kShare = 0.002;

/// A calibrated frame, its scale known to a millionth.
Frame calibrated() {
  Frame frame = noisy(vacuum(), 5);
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 0.004;
  return frame;
}

/// The map's scale is off by kShare at `slope` 0; at another slope it grows along x by that share in 4000 px.
MapError error_of(const Frame& frame, double slope) {
  const auto share = [&](const PointPx& p) { return kShare * (1.0 + slope * p.x / 4000.0); };
  MapError error;
  for (const BallImage& image : frame.images) {
    const double s = share(image.centre_px);
    error.images.push_back(
        {{s * image.centre_px.x, s * image.centre_px.y}, s * image.diameter_px, slope * 1e-3});
  }
  for (const PointPx& p : frame.surface_px) error.surface_px.push_back({share(p) * p.x, share(p) * p.y});
  return error;
}

Frame moved(Frame frame, double sds) {
  const auto errors = frame.map_errors;
  for (const MapError& error : errors) {
    for (std::size_t i = 0; i < frame.images.size(); ++i) {
      frame.images[i].centre_px.x += sds * error.images[i].centre_px.x;
      frame.images[i].centre_px.y += sds * error.images[i].centre_px.y;
      frame.images[i].diameter_px += sds * error.images[i].diameter_px;
      if (frame.images[i].equator_rad) *frame.images[i].equator_rad += sds * error.images[i].equator_rad;
    }
    for (std::size_t i = 0; i < frame.surface_px.size(); ++i) {
      frame.surface_px[i].x += sds * error.surface_px[i].x;
      frame.surface_px[i].y += sds * error.surface_px[i].y;
    }
  }
  return frame;
}

}  // namespace

TEST_GROUP(MapErrors){};

TEST(MapErrors, OfScaleAloneAreInVelocitiesAndNotInRatios) {
  Frame frame = calibrated();
  const Readout without = reduced(frame);
  frame.map_errors = {error_of(frame, 0.0)};
  const Readout with = reduced(frame);
  // Gravity and the calibrated scale hold a little against it: within 1 % of the share.
  const double vx = *with.value[Quantity::vx_td_mps];
  equal(std::hypot(*without.sd[Quantity::vx_td_mps], kShare * vx), with.sd[Quantity::vx_td_mps],
        0.01 * kShare * vx);
  equal(*without.sd[Quantity::e], with.sd[Quantity::e], 0.01 * *without.sd[Quantity::e]);
  equal(*without.value[Quantity::mu], with.value[Quantity::mu]);
}

TEST(MapErrors, AreThoseOfTheFrameSoMoved) {
  for (const double slope : {0.0, 1.0, -3.0}) {
    Frame frame = calibrated();
    const Readout without = reduced(frame);
    frame.map_errors = {error_of(frame, slope)};
    const Readout with = reduced(frame);
    const Readout up = reduced(moved(frame, 0.01)), down = reduced(moved(frame, -0.01));
    for (const Quantity q : {Quantity::mu, Quantity::e, Quantity::vx_lo_mps, Quantity::omega_td_radps}) {
      const double part = (*up.value[q] - *down.value[q]) / 0.02;
      const double expected = std::hypot(*without.sd[q], part);
      equal(expected, with.sd[q], 1e-3 * expected);  // a full sd against a hundredth: the curvature between
    }
  }
}

TEST(MapErrors, AreInTheCovarianceAndMirroredWithTheBall) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 1.0)};
  const auto of = [](const Frame& f) { return *reduce(f, Estimator::best, {.covariance = true}); };
  const Readout right = of(frame);
  equal(*right.sd[Quantity::vx_td_mps], std::sqrt((*right.covariance)[0][0]), 1e-9);
  for (BallImage& image : frame.images) {
    image.centre_px.x = -image.centre_px.x;
    *image.equator_rad = -*image.equator_rad;
  }
  for (PointPx& p : frame.surface_px) p.x = -p.x;
  for (MapError::Shift& s : frame.map_errors[0].images) {
    s.centre_px.x = -s.centre_px.x;
    s.equator_rad = -s.equator_rad;
  }
  for (PointPx& p : frame.map_errors[0].surface_px) p.x = -p.x;
  equal(*right.sd[Quantity::mu], of(frame).sd[Quantity::mu], 1e-9);
}

TEST(MapErrors, ThatDoNotBelongToTheFrameAreRefused) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 0.0)};
  frame.map_errors[0].images.pop_back();
  STRCMP_EQUAL("map_errors[0].images: must be one for each image", complaint(frame).c_str());
  frame.map_errors = {error_of(frame, 0.0)};
  frame.map_errors[0].surface_px[0].x = std::nan("");
  STRCMP_EQUAL("map_errors[0].surface_px: must be two numbers from -1e12 to 1e12", complaint(frame).c_str());
  frame.map_errors.assign(65, error_of(frame, 0.0));
  STRCMP_EQUAL("map_errors: at most 64", complaint(frame).c_str());
}

TEST(MapErrors, GoWithTheSurfacePointThatIsLeftOut) {
  Frame frame = calibrated();
  frame.map_errors = {error_of(frame, 0.0)};
  frame.surface_px.push_back({frame.surface_px[1].x + 40.0, frame.surface_px[1].y + 60.0});
  frame.map_errors[0].surface_px.push_back({1.0, 1.0});
  const Readout r = reduced(frame);
  CHECK_TRUE(r.flags.has(Flag::outlier_surface_point));
  CHECK_TRUE(r.sd[Quantity::mu].has_value());
}

TEST(MapErrors, AScaleWithoutAnSdIsToldAndOneOfZeroIsNot) {
  Frame frame = calibrated();
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m_sd = 0.0;
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m_sd.reset();
  CHECK_TRUE(reduced(frame).flags.has(Flag::scale_sd_unknown));
  frame.px_per_m.reset();
  CHECK_FALSE(reduced(frame).flags.has(Flag::scale_sd_unknown));
}

// The numbers' derivatives by the images' times.

namespace {

/// Smooth in the measurements: the same images in use, the same effects.
Readout of(const Frame& frame, bool by_time = false) {
  return *reduce(frame, Estimator::best,
                 {.effects = flight::Effects{}, .reject_outliers = false, .by_time = by_time});
}

Frame later(Frame frame, std::size_t image, double by_s) {
  frame.images[image].time_s += by_s;
  return frame;
}

/// How far the derivatives are off, over what the noise of the image's own place makes of the number: both by the time
/// in which the ball flies an sd of its place.
double largest_share_off(const Frame& frame) {
  constexpr double kStep_s = 1e-7;
  constexpr double kUnit_s = 0.5e-3 / 17.0;  // sd of the place over the speed
  const Readout readout = of(frame, true);
  LONGS_EQUAL(frame.images.size(), readout.by_time.size());
  double worst = 0.0;
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    const auto q = static_cast<Quantity>(k);
    if (!readout.value[q]) continue;
    for (std::size_t i = 0; i < frame.images.size(); ++i) {
      const double up = *of(later(frame, i, kStep_s)).value[q];
      const double down = *of(later(frame, i, -kStep_s)).value[q];
      const double slope = (up - down) / (2.0 * kStep_s);
      const double share = std::abs(slope - readout.by_time[i][k]) * kUnit_s / *readout.sd[q];
      worst = std::max(worst, share);
    }
  }
  return worst;
}

}  // namespace

TEST_GROUP(TimeResponse){};

TEST(TimeResponse, IsThatOfTheFrameAtOtherTimes) {
  for (const double noise : {0.01, 1.0}) {
    Setup setup;
    setup.noise_factor = noise;
    Frame frame = noisy(setup, 4);
    frame.temperature_c = 21.0;
    // Left out: products with residuals, which are hundredths of the way from image to image, and the lift's change.
    const double off = largest_share_off(frame);
    CHECK_TEXT(off < 0.01, std::to_string(off).c_str());
  }
}

TEST(TimeResponse, AllowsForCalibratedScaleAndErrorsInTime) {
  Frame frame = noisy(Setup{}, 6);
  frame.px_per_m = 4000.0;
  frame.px_per_m_sd = 4.0;
  for (BallImage& image : frame.images) image.time_sd_s = 20e-6;
  const double off = largest_share_off(frame);
  CHECK_TEXT(off < 0.01, std::to_string(off).c_str());
}

TEST(TimeResponse, OfAShiftOfAllImagesIsNone) {
  Frame frame = noisy(Setup{}, 3);
  const Readout readout = of(frame, true);
  for (std::size_t k = 0; k < kQuantityCount; ++k) {
    double sum = 0.0, largest = 0.0;
    for (const TimeDerivatives& by_time : readout.by_time) {
      sum += by_time[k];
      largest = std::max(largest, std::abs(by_time[k]));
    }
    // The spin's decay and lift count from the leg's own middle, and move with it.
    CHECK_TEXT(std::abs(sum) <= 1e-3 * largest, std::string(kQuantityNames[k]).c_str());
  }
}

TEST(TimeResponse, IsGivenOnlyIfAskedFor) { CHECK_TRUE(of(noisy()).by_time.empty()); }

// Numbers with a divisor near zero: the instants of a slow leg, and what hangs on them; e and mu.

namespace {

/// In a vacuum without gravity, whose pull would bend a slow leg within its uncertain instant.
Setup weightless() {
  Setup setup = vacuum();
  setup.gravity_mps2 = 0.0;
  return setup;
}

Readout first_order(const Frame& frame) {
  const auto readout = reduce(frame, Estimator::best, {.effects = flight::kNoEffects, .covariance = true});
  CHECK_TRUE(readout.has_value());
  return *readout;
}

Frame rebounding_at(double vy_lo) {
  Bounce bounce;
  bounce.vy_lo = vy_lo;
  Setup setup = weightless();
  setup.noise_factor = 0.0;
  test::Random random(5);
  Frame frame = test::photograph(bounce, setup, random);
  for (BallImage& image : frame.images)  // so that the lift-off alone makes the dwell uncertain
    if (image.leg == Leg::incoming) image.centre_cov_px2 = {1e-6, 0.0, 0.0, 1e-6};
  frame.surface_sd_px = 1e-3;
  return frame;
}

}  // namespace

TEST_GROUP(DivisorsNearZero){};

TEST(DivisorsNearZero, LeaveAnOrdinaryShotToTheFirstOrder) {
  const Readout r = first_order(rebounding_at(5.76));
  const PrimaryCovariance& c = *r.covariance;
  // To rounding: both from the same factor.
  DOUBLES_EQUAL(1e3 * std::sqrt(c[3][3] + c[7][7] - 2.0 * c[3][7]), *r.sd[Quantity::dwell_time_ms], 1e-9);
}

// Fieller: lift-offs t at which the height vy (t - t_lo) is within 4 of its sds. By bisection, from the covariance.
TEST(DivisorsNearZero, ReachAsFarAsTheInstantsThatFourSdDoNotExclude) {
  const Readout r = first_order(rebounding_at(0.4));
  const PrimaryCovariance& c = *r.covariance;
  const double vy = *r.value[Quantity::vy_lo_mps], share = std::sqrt(c[5][5]) / vy;
  CHECK_TRUE(share > 0.1 && share < 0.2);
  double farthest = 0.0;
  for (const double side : {-1.0, 1.0}) {
    const auto excluded = [&](double off_s) {
      const double t = side * off_s;
      const double variance = vy * vy * c[7][7] - 2.0 * vy * c[5][7] * t + c[5][5] * t * t;
      return vy * vy * t * t > 16.0 * variance;
    };
    double within = 0.0, beyond = 1.0;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (within + beyond);
      (excluded(middle) ? beyond : within) = middle;
    }
    farthest = std::max(farthest, within);
  }
  // Less what the lift-off has in the first order. A twentieth of an sd does not count, 1/400 of the variance.
  const double expected = 1e3 * std::sqrt(c[3][3] - 2.0 * c[3][7] + farthest * farthest / 25.0);
  DOUBLES_EQUAL(expected, *r.sd[Quantity::dwell_time_ms], expected / 400.0);
}

TEST(DivisorsNearZero, WithinFourSdOfZeroGiveNoNumber) {
  const Readout r = first_order(rebounding_at(0.2));
  CHECK_TRUE(*r.value[Quantity::vy_lo_mps] < 4.0 * *r.sd[Quantity::vy_lo_mps]);
  CHECK_TRUE(r.flags.has(Flag::degenerate_geometry));
  for (const Quantity q : {Quantity::dwell_time_ms, Quantity::dwell_distance_cm})
    CHECK_FALSE(r.value[q] || r.sd[q] || r.sd_systematic[q] || r.degrees_of_freedom[q]);
  // Nothing is divided by vy at lift-off in these.
  for (const Quantity q :
       {Quantity::vy_lo_mps, Quantity::vx_lo_mps, Quantity::theta_out_deg, Quantity::e, Quantity::mu})
    CHECK_TRUE(r.value[q] && r.sd[q]);
  CHECK_FALSE(r.covariance.has_value());
}

// Slow and grazing legs of few images, digitized by hand. Noise that leaves a leg within 4 sd, as all but one in 16,000
// do, leaves its numbers within 5 of theirs: in 4,000 shots half a leg is expected beyond, and more than 5 once in 10^5
// runs. By the first order alone some fifty shots are.
TEST(DivisorsNearZero, KeepStatedSdsTrueOnSlowAndGrazingLegs) {
  constexpr int kShots = testing::repetitions(4000);
  test::Random random{seed()};
  const auto uniform = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  int beyond = 0, told = 0;
  for (int shot = 0; shot < kShots; ++shot) {
    Bounce bounce;
    bounce.vy_lo = std::exp(uniform(std::log(0.1), std::log(3.0)));
    if (shot % 2 == 0) bounce.vy_td = -std::exp(uniform(std::log(0.3), std::log(6.0)));
    Setup setup = vacuum();
    setup.incoming = static_cast<int>(uniform(3.0, 9.0));
    setup.rebound = static_cast<int>(uniform(3.0, 9.0));
    setup.phase = uniform(0.06, 0.94);
    const Readout r = reduced(test::photograph(bounce, setup, random));
    const Quantities truth = test::truth(bounce);
    bool off = false;
    for (const Quantity q : {Quantity::theta_in_deg, Quantity::theta_out_deg, Quantity::e, Quantity::mu,
                             Quantity::dwell_time_ms, Quantity::dwell_distance_cm})
      off = off || (r.value[q] && std::abs(*r.value[q] - *truth[q]) > 5.0 * *r.sd[q]);
    beyond += off;
    told += r.value[Quantity::dwell_time_ms].has_value();
    CHECK_TRUE(r.value[Quantity::dwell_time_ms] || r.flags.has(Flag::degenerate_geometry) ||
               r.flags.has(Flag::too_few_images));
  }
  std::printf("(%d of %d beyond, %d with a dwell time)", beyond, kShots, told);
  CHECK_TRUE(beyond <= 5);
  CHECK_TRUE(2 * told > kShots);
}
