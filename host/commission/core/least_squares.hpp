// Least squares of few unknowns. No template: one decomposition is compiled for all sizes. Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>

namespace strobe::commission {

/// The unknowns from the normal equations' matrix and right side.
inline Eigen::VectorXd solve_normal(const Eigen::MatrixXd& information, const Eigen::VectorXd& right) {
  return information.ldlt().solve(right);
}

}  // namespace strobe::commission
