#include "common/impact/fit/bounded_least_squares.hpp"

#include <cmath>

#include <CppUTest/TestHarness.h>

using namespace Eigen;
using namespace strobe::impact;

namespace {

/// Orthogonal, and exact but for the rounding of its entries.
MatrixXd reflection(Index n, double seed) {
  VectorXd v(n);
  for (Index i = 0; i < n; ++i) v[i] = std::sin(seed + static_cast<double>(i * i + i));
  return MatrixXd::Identity(n, n) - (2.0 / v.squaredNorm()) * v * v.transpose();
}

LeastSquaresProblem plane(std::function<VectorXd(const VectorXd&)> residuals, Vector2d lower,
                          Vector2d upper) {
  return {.residuals = std::move(residuals), .lower = lower, .upper = upper, .scale = Vector2d(1.0, 1.0)};
}

VectorXd rosenbrock(const VectorXd& x) { return Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]); }

}  // namespace

TEST_GROUP(BoundedLeastSquares){};

// J = U·S·Vᵀ with singular values from 1 down to 1/condition has the inverse Gram matrix V·S⁻²·Vᵀ. Rounding
// J's entries alone moves that by 2·condition·eps; the rest is room for the factorization's own rounding.
TEST(BoundedLeastSquares, TheInverseGramMatrixHoldsUpToConditionNumbersOf1e12) {
  for (const double condition : {1.0, 1e3, 1e6, 1e9, 1e12}) {
    const MatrixXd u = reflection(12, 0.3);
    const MatrixXd v = reflection(4, 1.7);
    VectorXd s(4);
    for (Index i = 0; i < 4; ++i) s[i] = std::pow(condition, -static_cast<double>(i) / 3.0);
    const MatrixXd jac = u.leftCols(4) * s.asDiagonal() * v.transpose();
    const MatrixXd expected = v * s.cwiseInverse().cwiseAbs2().asDiagonal() * v.transpose();
    const auto inverse = unscaled_covariance(jac);
    CHECK(inverse.has_value());
    const double error = (*inverse - expected).norm() / expected.norm();
    CHECK_COMPARE(error, <=, 40.0 * condition * 2.2e-16);
  }
}

TEST(BoundedLeastSquares, ColumnsInAnyUnitGiveTheSameInverse) {
  const MatrixXd jac = reflection(9, 0.4).leftCols(3);
  const Eigen::Vector3d units(1e-150, 1.0, 1e150);
  const auto inverse = unscaled_covariance(jac * units.asDiagonal());
  CHECK(inverse.has_value());
  for (Index i = 0; i < 3; ++i) DOUBLES_EQUAL(1.0, (*inverse)(i, i) * units[i] * units[i], 1e-13);
}

TEST(BoundedLeastSquares, ColumnsThatDependOnEachOtherHaveNoInverse) {
  MatrixXd jac = reflection(8, 0.5).leftCols(3);
  jac.col(2) = 3.0 * jac.col(0) - jac.col(1);
  CHECK(!unscaled_covariance(jac));
  jac.col(2).setZero();
  CHECK(!unscaled_covariance(jac));
  CHECK(!unscaled_covariance(MatrixXd::Ones(2, 3)));
  jac(0, 2) = std::nan("");
  CHECK(!unscaled_covariance(jac));
  LONGS_EQUAL(0, unscaled_covariance(MatrixXd(5, 0))->size());
}

TEST(BoundedLeastSquares, FindsTheEndOfRosenbrocksValley) {
  const auto problem = plane(rosenbrock, {-5, -5}, {5, 5});
  const LeastSquaresResult found = levenberg_marquardt(problem, Vector2d(-1.2, 1.0));
  CHECK(converged(found.termination));
  DOUBLES_EQUAL(1.0, found.parameters[0], 1e-12);
  DOUBLES_EQUAL(1.0, found.parameters[1], 1e-12);
}

// On x = 1/2 the least of 100(y - x²)² + (1 - x)² is at y = 1/4. Its value of 1/4 hides departures of y of up
// to sqrt(4 eps/400) behind rounding.
TEST(BoundedLeastSquares, StopsAtABoundAndMovesAlongIt) {
  const LeastSquaresResult found =
      levenberg_marquardt(plane(rosenbrock, {-5, -5}, {0.5, 5}), Vector2d(-1.2, 1.0));
  CHECK(converged(found.termination));
  DOUBLES_EQUAL(0.5, found.parameters[0], 0.0);
  DOUBLES_EQUAL(0.25, found.parameters[1], 1e-8);
}

TEST(BoundedLeastSquares, LeavesABoundThatItWasStartedOn) {
  const LeastSquaresResult found =
      levenberg_marquardt(plane(rosenbrock, {-5, 0}, {5, 5}), Vector2d(0.0, 0.0));
  DOUBLES_EQUAL(1.0, found.parameters[0], 1e-12);
}

// The residuals' derivatives jump where the minimum is, on a ridge along neither axis.
TEST(BoundedLeastSquares, FindsAMinimumOnAKink) {
  const auto residuals = [](const VectorXd& x) -> VectorXd {
    return Vector2d(1.0 + 3.0 * std::abs(x[0] - 0.3), x[1] - x[0]);
  };
  const LeastSquaresResult found = minimize(plane(residuals, {-2, -2}, {2, 2}), Vector2d(-1.0, 1.5), {}, 0);
  DOUBLES_EQUAL(0.3, found.parameters[0], 1e-7);
  DOUBLES_EQUAL(1.0, found.sum_of_squares, 1e-6);
}

TEST(BoundedLeastSquares, TakesTheBestOfSeveralValleys) {
  const auto residuals = [](const VectorXd& x) -> VectorXd {
    return Vector2d(std::min(std::abs(x[0] + 1.0) + 0.5, std::abs(x[0] - 1.0)), x[1]);
  };
  const auto problem = plane(residuals, {-2, -2}, {2, 2});
  const LeastSquaresResult found =
      minimize(problem, Vector2d(-1.1, 0.0), {Vector2d(-0.8, 1.0), Vector2d(0.7, 1.0)}, 1);
  DOUBLES_EQUAL(1.0, found.parameters[0], 1e-9);
}

TEST(BoundedLeastSquares, AParameterWithoutEffectStaysWhereItWas) {
  const auto residuals = [](const VectorXd& x) -> VectorXd { return Vector2d(x[0] - 0.5, 2.0 * x[0]); };
  const LeastSquaresResult found =
      levenberg_marquardt(plane(residuals, {-2, -2}, {2, 2}), Vector2d(1.0, 0.75));
  DOUBLES_EQUAL(0.1, found.parameters[0], 1e-14);
  DOUBLES_EQUAL(0.75, found.parameters[1], 0.0);
}

// The root of 2 has no residual beyond 3/2: the first steps from 1/10 overshoot there.
TEST(BoundedLeastSquares, KeepsAwayFromWhereResidualsAreInfinite) {
  const auto residuals = [](const VectorXd& x) -> VectorXd {
    if (x[0] > 1.5) return Vector2d::Constant(INFINITY);
    return Vector2d(x[0] * x[0] - 2.0, 0.1 * x[1]);
  };
  const LeastSquaresResult found = levenberg_marquardt(plane(residuals, {0, -2}, {9, 2}), Vector2d(0.1, 1.0));
  CHECK(converged(found.termination));
  CHECK(found.iterations > 1);
  DOUBLES_EQUAL(std::sqrt(2.0), found.parameters[0], 1e-12);
  DOUBLES_EQUAL(0.0, found.parameters[1], 1e-12);
}

// The least sum is 1; where a step gains less than a hundredth of it the end is near.
TEST(BoundedLeastSquares, StopsWhereTheGainAskedForIsNotToBeHad) {
  const auto residuals = [](const VectorXd& x) -> VectorXd {
    return Eigen::Vector3d(std::exp(x[0]) - 2.0, x[1] - 0.5, 1.0);
  };
  auto problem = plane(residuals, {-5, -5}, {5, 5});
  const LeastSquaresResult whole = levenberg_marquardt(problem, Vector2d(1.0, 1.0));
  problem.function_tolerance = 0.01;
  const LeastSquaresResult early = levenberg_marquardt(problem, Vector2d(1.0, 1.0));
  CHECK(converged(whole.termination) && converged(early.termination));
  CHECK(early.iterations < whole.iterations);
  DOUBLES_EQUAL(1.0, whole.sum_of_squares, 1e-14);
  DOUBLES_EQUAL(1.0, early.sum_of_squares, 0.01);
}

// Differences to second order: the error is a third derivative's share of the squared step, (6e-6)².
TEST(BoundedLeastSquares, DerivativesAtABoundAreAsGoodAsInside) {
  const auto residuals = [](const VectorXd& x) -> VectorXd {
    return Vector2d(std::exp(x[0]), std::sin(x[1]));
  };
  const MatrixXd jac = jacobian(plane(residuals, {0.0, -3.0}, {1.0, 1.0}), Vector2d(0.0, 1.0));
  DOUBLES_EQUAL(1.0, jac(0, 0), 1e-9);
  DOUBLES_EQUAL(std::cos(1.0), jac(1, 1), 1e-9);
  DOUBLES_EQUAL(0.0, jac(0, 1), 0.0);
}

TEST(BoundedLeastSquares, SaysWhyItStopped) {
  const auto stop_of = [](auto residuals, const Vector2d& start) {
    return levenberg_marquardt(plane(residuals, {0, 0}, {9, 9}), start).termination;
  };
  CHECK(Termination::tolerance == stop_of(rosenbrock, {0.5, 0.5}));
  const auto outwards = [](const VectorXd& x) -> VectorXd { return Vector2d(1.0 + x[0], 2.0 + x[1]); };
  CHECK(Termination::no_free_parameter == stop_of(outwards, {0.0, 0.0}));
  const auto undefined = [](const VectorXd&) -> VectorXd { return Vector2d::Constant(INFINITY); };
  CHECK(Termination::not_finite == stop_of(undefined, {1.0, 1.0}));
  CHECK(!converged(Termination::iteration_limit) && !converged(Termination::not_finite));
}

// A staircase: flat wherever a derivative is taken, so that only steps along the axes descend it, 2e10 of them.
TEST(BoundedLeastSquares, AnEndlessSlopeIsLeftAfterAThousandRounds) {
  int evaluations = 0;
  auto problem = plane(
      [&](const VectorXd& x) {
        ++evaluations;
        return Vector2d(1e9 - 0.05 * std::floor(20.0 * x[0] + 0.5), 1.0);
      },
      Vector2d(0.0, 0.0), Vector2d(1e9, 1.0));
  const auto found = minimize(problem, Vector2d(1.0, 0.5), {}, 0);
  CHECK_COMPARE(found.parameters[0], >, 10.0);
  // Four steps a round; of the two runs before and after it a few dozen.
  CHECK_COMPARE(evaluations, <, 5000);
}
