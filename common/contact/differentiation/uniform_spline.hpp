// Quintic B-splines on uniform knots over 0…1 (C. de Boor, A Practical Guide to Splines, chapter X).
// Pure; thread-safe; allocates.
#pragma once

#include <Eigen/Dense>

namespace strobe::contact {

inline constexpr int kSplineDegree = 5;

/// Values at t (0…1) of the `order`-th derivative (0…3) of the intervals + 5 basis functions.
Eigen::RowVectorXd spline_row(int intervals, double t, int order);

/// Matrix D with |D·c|² = integral over 0…1 of the squared third derivative (exact: three-point Gauss rule).
Eigen::MatrixXd roughness_factor(int intervals);

}  // namespace strobe::contact
