#include "common/reduction/factorization.hpp"

namespace strobe::reduction {
namespace {

double quotient(double numerator, double diagonal) { return diagonal != 0.0 ? numerator / diagonal : 0.0; }

/// Forward substitution with the transpose of an upper triangle, in place.
template <std::size_t N>
void solve_transposed(const double (&r)[N][N], double* y) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < i; ++k) y[i] -= r[k][i] * y[k];
    y[i] = quotient(y[i], r[i][i]);
  }
}

/// Back substitution, in place.
template <std::size_t N>
void solve(const double (&r)[N][N], double* x) {
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t k = i + 1; k < N; ++k) x[i] -= r[i][k] * x[k];
    x[i] = quotient(x[i], r[i][i]);
  }
}

}  // namespace

JointVector SquareRootInformation::whitened(const JointVector& gradient) const {
  JointVector y = gradient;
  for (std::size_t l = 0; l < 2; ++l) {
    double* own = &y[kLegStart[l]];
    solve_transposed(leg[l].r, own);
    for (std::size_t i = 0; i < 4; ++i) {
      y[kTilt] -= leg[l].coupling[i][0] * own[i];
      y[kScale] -= leg[l].coupling[i][1] * own[i];
    }
  }
  solve_transposed(r, y.data());
  return y;
}

std::array<double, 7> SquareRootInformation::whitened(std::size_t l,
                                                      const std::array<double, 6>& gradient) const {
  std::array<double, 7> y{gradient[0], gradient[1], gradient[2], gradient[3], gradient[4], 0.0, gradient[5]};
  solve_transposed(leg[l].r, y.data());
  for (std::size_t i = 0; i < 4; ++i) {
    y[4] -= leg[l].coupling[i][0] * y[i];
    y[6] -= leg[l].coupling[i][1] * y[i];
  }
  solve_transposed(r, &y[4]);
  return y;
}

std::array<double, 7> SquareRootInformation::shared(double by_tilt, double by_height, double by_scale) const {
  std::array<double, 7> y{0.0, 0.0, 0.0, 0.0, by_tilt, by_height, by_scale};
  solve_transposed(r, &y[4]);
  return y;
}

JointVector SquareRootInformation::unknowns(const JointVector& y) const {
  JointVector x = y;
  solve(r, x.data());
  for (std::size_t l = 0; l < 2; ++l) {
    double* own = &x[kLegStart[l]];
    for (std::size_t i = 0; i < 4; ++i) {
      own[i] -= leg[l].coupling[i][0] * x[kTilt] + leg[l].coupling[i][1] * x[kScale];
    }
    solve(leg[l].r, own);
  }
  return x;
}

}  // namespace strobe::reduction
