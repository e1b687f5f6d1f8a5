// The joint fit's least squares against the same problem solved in fifty digits, at condition numbers up to
// 1e12. The reference forms the normal equations, which fifty digits can afford: 2 x 12 of them are lost.
#include <algorithm>
#include <boost/multiprecision/cpp_dec_float.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/reduction/factorization.hpp"
#include "common/reduction/joint_fit.hpp"
#include "common/reduction/reduce.hpp"
#include "common/reduction/running_statistics.hpp"
#include "tests/common/reduction/reduced_frames.hpp"

#include <CppUTest/TestHarness.h>

using namespace strobe;
using namespace strobe::reduction;

namespace {

using Big = boost::multiprecision::cpp_dec_float_50;
using BigVector = std::vector<Big>;
using BigMatrix = std::vector<BigVector>;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Symmetric positive definite m x = b by elimination; also the inverse's diagonal if asked for.
BigVector solved(BigMatrix m, BigVector b) {
  const std::size_t n = b.size();
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t r = k + 1; r < n; ++r) {
      const Big factor = m[r][k] / m[k][k];
      for (std::size_t c = k; c < n; ++c) m[r][c] -= factor * m[k][c];
      b[r] -= factor * b[k];
    }
  }
  for (std::size_t k = n; k-- > 0;) {
    for (std::size_t c = k + 1; c < n; ++c) b[k] -= m[k][c] * b[c];
    b[k] /= m[k][k];
  }
  return b;
}

/// Flight without gravity through a levelled photograph: unknowns in the order of the joint fit. The model is
/// linear but for the surface line's tilt, which is iterated.
struct Reference {
  BigVector unknowns;
  BigVector variances;
  /// Of the whitened matrix with columns of length 1, from both ends of its spectrum.
  double condition = 0.0;
};

struct BigRows {
  BigMatrix rows;
  BigVector right;
  void add(const BigVector& row, const Big& residual, const Big& sd) {
    BigVector scaled = row;
    for (Big& x : scaled) x /= sd;
    rows.push_back(scaled);
    right.push_back(residual / sd);
  }
};

BigRows rows_about(const Observations& all, const JointFit& layout, const BigVector& z) {
  using boost::multiprecision::cos;
  using boost::multiprecision::sin;
  BigRows system;
  const auto zeros = [] { return BigVector(kJointCount, Big(0)); };
  for (const Observation& o : all.images) {
    const std::size_t leg = leg_index(*o.leg), k = kLegStart[leg];
    const Big s = (Big(o.time_s) - layout.legs[leg].origin_s) / layout.legs[leg].span_s;
    const Big rx = Big(o.centre_m.x()) - z[k] - z[k + 2] * s;
    const Big ry = Big(o.centre_m.y()) - z[k + 1] - z[k + 3] * s;
    const Big lxx = o.centre_cholesky_m.xx;
    const Big lyx = o.centre_cholesky_m.yx;
    const Big lyy = o.centre_cholesky_m.yy;
    BigVector x = zeros();
    BigVector y = zeros();
    x[k] = y[k + 1] = 1;
    x[k + 2] = y[k + 3] = s;
    for (std::size_t c = 0; c < kJointCount; ++c) y[c] -= lyx / lxx * x[c];
    system.add(x, rx, lxx);
    system.add(y, ry - lyx / lxx * rx, lyy);
    BigVector d = zeros();
    d[kScale] = all.ball_diameter_m;
    system.add(d, Big(o.diameter_m) - z[kScale] * all.ball_diameter_m, o.diameter_sd_m);
  }
  for (const Eigen::Vector2d& p : all.surface_m) {
    BigVector row = zeros();
    row[kTilt] = cos(z[kTilt]) * p.x() + sin(z[kTilt]) * p.y();
    row[kHeight] = 1;
    system.add(row, cos(z[kTilt]) * p.y() - sin(z[kTilt]) * p.x() - z[kHeight], all.surface_sd_m);
  }
  return system;
}

BigMatrix normal(const BigRows& system) {
  BigMatrix m(kJointCount, BigVector(kJointCount, Big(0)));
  for (const BigVector& row : system.rows) {
    for (std::size_t i = 0; i < kJointCount; ++i)
      for (std::size_t k = 0; k < kJointCount; ++k) m[i][k] += row[i] * row[k];
  }
  return m;
}

/// Ratio of the extreme singular values with columns of length 1, by power iteration on the normal matrix
/// (largest) and on its inverse (smallest): a lower bound, good to a few per cent.
double condition_number(BigMatrix m) {
  BigVector length(kJointCount);
  for (std::size_t i = 0; i < kJointCount; ++i) length[i] = sqrt(m[i][i]);
  for (std::size_t i = 0; i < kJointCount; ++i)
    for (std::size_t k = 0; k < kJointCount; ++k) m[i][k] /= length[i] * length[k];
  const auto norm = [](const BigVector& v) {
    Big sum = 0;
    for (const Big& x : v) sum += x * x;
    return Big(sqrt(sum));
  };
  BigVector small(kJointCount);
  for (std::size_t i = 0; i < kJointCount; ++i) small[i] = 1 + Big(i) / 7;
  BigVector large = small;
  Big least = 0;
  Big most = 0;
  for (int step = 0; step < 30; ++step) {
    small = solved(m, small);
    least = 1 / norm(small);
    for (Big& x : small) x *= least;
    BigVector next(kJointCount, Big(0));
    for (std::size_t i = 0; i < kJointCount; ++i)
      for (std::size_t k = 0; k < kJointCount; ++k) next[i] += m[i][k] * large[k];
    most = norm(next);
    for (Big& x : next) x /= most;
    large = next;
  }
  return static_cast<double>(sqrt(Big(most / least)));
}

Reference reference(const Observations& all, const JointFit& layout) {
  Reference result;
  result.unknowns.assign(kJointCount, Big(0));
  result.unknowns[kScale] = 1;
  BigMatrix m;
  for (int step = 0; step < 12; ++step) {
    const BigRows system = rows_about(all, layout, result.unknowns);
    m = normal(system);
    BigVector right(kJointCount, Big(0));
    for (std::size_t r = 0; r < system.rows.size(); ++r)
      for (std::size_t i = 0; i < kJointCount; ++i) right[i] += system.rows[r][i] * system.right[r];
    const BigVector change = solved(m, right);
    for (std::size_t i = 0; i < kJointCount; ++i) result.unknowns[i] += change[i];
  }
  for (std::size_t i = 0; i < kJointCount; ++i) {
    BigVector unit(kJointCount, Big(0));
    unit[i] = 1;
    result.variances.push_back(solved(m, unit)[i]);
  }
  result.condition = condition_number(m);
  return result;
}

/// A bounce without noise but for a millimetre of zigzag, so that residuals are not zero.
Observations scene() {
  Observations all;
  all.ball_diameter_m = 0.0651;
  all.surface_m = {{-0.20, 0.0002}, {-0.12, -0.0003}, {0.18, 0.0004}, {0.26, -0.0001}};
  all.surface_sd_m = 0.5e-3;
  for (int i = 0; i < 8; ++i) {
    Observation o;
    const bool in = i < 4;
    const double t = in ? (i - 4) * 3e-3 : (i - 3) * 3e-3;
    o.time_s = 0.012 + t;
    o.leg = in ? Leg::incoming : Leg::rebound;
    const double zigzag = (i % 2 == 0 ? 1e-3 : -0.7e-3);
    o.centre_m = in ? Eigen::Vector2d{15.6 * t + zigzag, 0.0325 - 6.7 * t - zigzag}
                    : Eigen::Vector2d{8.8 * t - zigzag, 0.0325 + 5.8 * t};
    o.diameter_m = 0.0651 + 0.3e-3 * (i % 3 - 1);
    o.centre_cholesky_m = {0.5e-3, 0.0, 0.5e-3};
    o.diameter_sd_m = 0.5e-3;
    o.use_centre = o.use_diameter = true;
    all.images.push_back(o);
  }
  return all;
}

/// Forward error of a backward stable solution: eps times the condition number, in units of the unknown's own
/// size (columns are scaled by their lengths, hence the sum over sd's that a column may bring along), plus
/// the millionth of an sd at which the iteration stops.
void agrees(const Observations& all, double least_condition) {
  const JointFit fit = fit_joint(all, {});
  const Reference exact = reference(all, fit);
  CHECK_TRUE_TEXT(exact.condition >= least_condition, std::to_string(exact.condition).c_str());
  const BigRows system = rows_about(all, fit, exact.unknowns);
  const BigMatrix m = normal(system);
  double size = 0.0;  // of the scaled unknowns
  double chi = 0.0;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double scaled = static_cast<double>(exact.unknowns[i] * sqrt(m[i][i]));
    size += scaled * scaled;
  }
  for (const Big& r : system.right) chi += static_cast<double>(r * r);
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double expected = static_cast<double>(exact.unknowns[i]);
    const double sd = static_cast<double>(sqrt(exact.variances[i]));
    const double unit = 1.0 / static_cast<double>(sqrt(m[i][i]));
    // Golub, Van Loan 5.3.7: error <= eps (2 cond |x| + cond^2 |r|/|A|); cond^2 eps |r| unit / |A| stays
    // below eps cond sd, as sd <= cond unit.
    const double tolerance =
        10.0 * kEpsilon * exact.condition * (unit * std::sqrt(size) + sd * std::sqrt(chi)) + 1e-6 * sd;
    char text[200];
    std::snprintf(text, sizeof text, "unknown %zu: %.17g, exact %.17g, sd %.3g, condition %.3g", i,
                  fit.unknowns[i], expected, sd, exact.condition);
    CHECK_TRUE_TEXT(std::abs(fit.unknowns[i] - expected) <= tolerance, text);
    JointVector gradient{};
    gradient[i] = 1.0;
    double variance = 0.0;
    for (const double y : fit.factor.whitened(gradient)) variance += y * y;
    const double ratio = std::sqrt(variance) / sd;
    std::snprintf(text, sizeof text, "sd of unknown %zu: ratio %.17g, condition %.3g", i, ratio,
                  exact.condition);
    CHECK_TRUE_TEXT(std::abs(ratio - 1.0) <= 20.0 * kEpsilon * exact.condition + 1e-9, text);
  }
}

}  // namespace

TEST_GROUP(LeastSquares){};

TEST(LeastSquares, AgreesWithFiftyDigitsOnAnOrdinaryShot) { agrees(scene(), 1.0); }

TEST(LeastSquares, AgreesWhereOneImageOutweighsTheOthers) {
  // One centre known 10^k times better: position and velocity are then known but for one combination.
  for (int k = 2; k <= 12; k += 2) {
    Observations all = scene();
    const double sd = 0.5e-3 * std::pow(10.0, -k);
    for (const std::size_t i : {0U, 7U}) all.images[i].centre_cholesky_m = {sd, 0.0, sd};
    agrees(all, 0.3 * std::pow(10.0, k));
  }
}

TEST(LeastSquares, AgreesWhereOneSurfacePointIsFarAway) {
  // The others' lever arm about the height is then next to nothing of the tilt's column.
  for (int k = 2; k <= 10; k += 2) {
    Observations all = scene();
    for (Eigen::Vector2d& p : all.surface_m) p.x() += std::pow(10.0, k);
    agrees(all, std::pow(10.0, k));
  }
}

TEST(LeastSquares, AgreesWhereTwoImagesAreNearlyAtOneTime) {
  for (const double gap_s : {1e-5, 1e-7, 1e-9}) {
    Observations all = scene();
    all.images[2].time_s = all.images[3].time_s - gap_s;
    all.images[2].centre_m = all.images[3].centre_m;
    agrees(all, 1.0);
  }
}

TEST(LeastSquares, AgreesForLegsOfMicroseconds) {
  for (const double shrink : {1e-3, 1e-6}) {
    Observations all = scene();
    for (Observation& o : all.images) o.time_s *= shrink;
    agrees(all, 1.0);
  }
}

TEST(LeastSquares, AgreesWhereCentresAreKnownOnlyAcrossALine) {
  for (const double correlation : {0.99, 0.999999, 1.0 - 1e-9}) {
    Observations all = scene();
    for (Observation& o : all.images) {
      o.centre_cholesky_m = {0.5e-3, correlation * 0.5e-3,
                             std::sqrt(1.0 - correlation * correlation) * 0.5e-3};
    }
    agrees(all, 1.0);
  }
}

TEST_GROUP(LegFactorization){};

TEST(LegFactorization, ManyRowsMakeTheTriangleOfTheirProducts) {
  // R^T R = A^T A, whatever the number of rows that are reflected together.
  for (const int count : {1, 2, 3, 15, 16, 17, 40, 200}) {
    HouseholderQr<3, 4> reduction;
    double products[4][4] = {};
    double rest = 0.0;
    const auto next = [&](const std::array<double, 1>& r) { rest += r[0] * r[0]; };
    for (int i = 0; i < count; ++i) {
      const std::array<double, 4> row{1.0, 0.1 * i, std::sin(i), std::cos(0.7 * i)};
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) products[a][b] += row[a] * row[b];
      reduction.add(row, next);
    }
    reduction.reflect(next);
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 4; ++b) {
        double product = 0.0;
        for (int k = 0; k <= a; ++k) product += reduction.triangle(k, a) * reduction.triangle(k, b);
        // 200 rows of numbers to 20: rounding of sums of 26,000.
        DOUBLES_EQUAL(products[a][b], product, 1e-10);
      }
    }
    double whole = rest;
    for (int k = 0; k < 3; ++k) whole += reduction.triangle(k, 3) * reduction.triangle(k, 3);
    DOUBLES_EQUAL(products[3][3], whole, 1e-10);
  }
}

// What is not known of the air, in the readout's numbers and uncertainties.
using namespace strobe::test;

namespace {

/// A twentieth of a pixel, as the digitizer measures.
Setup fine() {
  Setup setup;
  setup.centre_sd_m = setup.diameter_sd_m = setup.surface_sd_m = 0.0125e-3;
  setup.equator_sd_rad = 0.003;
  setup.incoming = setup.rebound = 10;
  return setup;
}

Readout in_air(const Frame& frame) { return *reduce(frame, Estimator::best); }

double z(const Readout& r, const Bounce& b, Quantity q) {
  const double sd = std::hypot(*r.sd[q], r.sd_systematic[q].value_or(0.0));
  return (*r.value[q] - *truth(b)[q]) / sd;
}

constexpr Quantity kOfPaths[] = {
    Quantity::theta_in_deg, Quantity::theta_out_deg, Quantity::vx_td_mps, Quantity::vy_td_mps,
    Quantity::vx_lo_mps,    Quantity::vy_lo_mps,     Quantity::e,         Quantity::mu,
    Quantity::dwell_time_ms};

template <typename Change>
void check_z(const Bounce& bounce, const Setup& setup, const Change& change) {
  // 40 shots: the mean square of z is 1 with an sd of 0.22, beyond 2 at most where the sd is too small.
  std::array<RunningStatistics, std::size(kOfPaths)> squares;
  test::Random random(test::seed_or(21));
  for (int shot = 0; shot < 40; ++shot) {
    Frame frame = test::photograph(bounce, setup, random);
    change(frame);
    const Readout r = in_air(frame);
    for (std::size_t i = 0; i < std::size(kOfPaths); ++i)
      squares[i].add(z(r, bounce, kOfPaths[i]) * z(r, bounce, kOfPaths[i]));
  }
  for (std::size_t i = 0; i < std::size(kOfPaths); ++i) {
    const std::string text = std::string(name(kOfPaths[i])) + " " + std::to_string(squares[i].mean());
    CHECK_TRUE_TEXT(squares[i].mean() < 2.0, text.c_str());
  }
}

/// Two spins that friction can tell from no other at this period.
Bounce topspin() {
  Bounce b;
  b.vx_td = 14.0, b.vy_td = -9.0, b.omega_td = -350.0;
  b.vx_lo = 13.0, b.vy_lo = 7.0, b.omega_lo = -400.0;
  return b;
}

}  // namespace

TEST_GROUP(AirFitting){};

TEST(AirFitting, AnUnreadSpinsLiftGoesIntoTheUncertaintyOfItsVelocities) {
  check_z(topspin(), fine(), [](Frame& frame) {
    for (BallImage& image : frame.images) image.equator_rad.reset();
  });
}

TEST(AirFitting, AnAliasedSpinsLiftGoesIntoTheUncertaintyOfItsVelocities) {
  Setup setup = fine();
  setup.period_s = 6e-3;
  setup.incoming = setup.rebound = 6;
  check_z(topspin(), setup, [](Frame&) {});
}

TEST(AirFitting, AnAliasedSpinMakesNoOutlierOfGoodImages) {
  Setup setup = fine();
  setup.period_s = 6e-3;
  setup.noise_factor = 0.0;
  setup.equator_sd_rad = 0.0175;  // or the spin's decay would tell
  const Readout r = in_air(noisy(setup, 1));
  CHECK_FALSE(r.flags.has(Flag::outlier_image));
  test::Random random(1);
  const Readout aliased = in_air(test::photograph(topspin(), setup, random));
  CHECK_TRUE(aliased.flags.has(Flag::spin_aliased));
  CHECK_FALSE(aliased.flags.has(Flag::outlier_image));
}

TEST(AirFitting, AnotherDragCoefficientIsWithinTheUncertainty) {
  for (const double coefficient : {0.48, 0.63}) {  // 1.5 sd
    Setup setup = fine();
    setup.air.drag_coefficient = coefficient;
    test::Random random(test::seed_or(22));
    for (int shot = 0; shot < 20; ++shot) {
      const Readout r = in_air(test::photograph(Bounce{}, setup, random));
      CHECK_FALSE(r.flags.has(Flag::outlier_image));
      for (const Quantity q : kOfPaths) CHECK_TRUE_TEXT(std::abs(z(r, Bounce{}, q)) < 5.0, name(q).data());
    }
  }
}

TEST(AirFitting, AnotherDecayOfTheSpinIsWithinTheUncertainty) {
  Setup setup = fine();
  setup.air.spin_decay_per_m = 0.02;  // two sd
  test::Random random(test::seed_or(23));
  for (int shot = 0; shot < 20; ++shot) {
    const Readout r = in_air(test::photograph(Bounce{}, setup, random));
    for (const Quantity q : {Quantity::omega_td_radps, Quantity::omega_lo_radps, Quantity::slip_lo_mps})
      CHECK_TRUE_TEXT(std::abs(z(r, Bounce{}, q)) < 5.5, name(q).data());
  }
}

TEST(AirFitting, AnotherDecayOfTheSpinIsNoContradiction) {
  // Read to 2 mrad over 60 ms: of 2 sd the angle of the rebound bends by some ten of its own.
  Setup setup = fine();
  setup.incoming = setup.rebound = 20;
  setup.equator_sd_rad = 2e-3;
  setup.air.spin_decay_per_m = 0.02;
  test::Random random(test::seed_or(24));
  for (int shot = 0; shot < 20; ++shot) {
    const Readout r = in_air(test::photograph(Bounce{}, setup, random));
    CHECK_FALSE(r.flags.has(Flag::residuals_exceed_noise));
    CHECK_FALSE(r.flags.has(Flag::outlier_image));
    CHECK_FALSE(r.flags.has(Flag::spin_aliased));
  }
}

TEST(AirFitting, TolerancesOfTheAirAreSystematic) {
  const Frame frame = noisy(fine());
  const Readout r = in_air(frame);
  // Half a leg of 0.24 m at 19 % of drag a metre... per coefficient: 0.09 · 0.019 /m · 0.12 m · 17 m/s = 3.5 mm/s,
  // of which the path tells a little.
  CHECK_TRUE(*r.sd_systematic[Quantity::v_td_mps] > 1e-4 && *r.sd_systematic[Quantity::v_td_mps] < 4e-3);
  Frame in_vacuum = frame;
  in_vacuum.air_density_kgpm3 = 0.0;
  CHECK_FALSE(in_air(in_vacuum).sd_systematic[Quantity::v_td_mps].has_value());
}

TEST(AirFitting, AKnownSpinLeavesTheStatisticalSdAtTheBound) {
  // What the fit loses to the air's errors is that of a coarse photograph: nothing to a thousandth.
  const Readout with = in_air(noisy(Setup{}));
  const Quantities bound = cramer_rao(Bounce{}, Setup{});
  for (const Quantity q : kOfPaths) DOUBLES_EQUAL(1.0, *with.sd[q] / *bound[q], 0.05);
}
