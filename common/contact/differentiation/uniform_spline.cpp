#include "common/contact/differentiation/uniform_spline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::contact {

Eigen::RowVectorXd spline_row(int intervals, double t, int order) {
  const double position = t * intervals;
  const int first = std::clamp(static_cast<int>(std::floor(position)), 0, intervals - 1);
  const double u = position - first;
  const int degree = kSplineDegree - order;
  // Cox–de Boor on uniform knots: the degree + 1 functions that are not zero on this interval.
  std::array<double, kSplineDegree + 1> local{1.0};
  for (int k = 1; k <= degree; ++k) {
    double saved = 0.0;
    for (int r = 0; r < k; ++r) {
      const auto i = static_cast<std::size_t>(r);
      const double share = local[i] / k;
      local[i] = saved + (r + 1 - u) * share;
      saved = (u + k - r - 1) * share;
    }
    local[static_cast<std::size_t>(k)] = saved;
  }
  Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(intervals + kSplineDegree);
  for (int r = 0; r <= degree; ++r) row(first + r) = local[static_cast<std::size_t>(r)];
  // Each derivative is a difference of the functions one degree lower.
  for (int d = degree + 1; d <= kSplineDegree; ++d) {
    for (int i = intervals + d - 1; i >= 0; --i) {
      const double lower = i > 0 ? row(i - 1) : 0.0;
      const double same = i < intervals + d - 1 ? row(i) : 0.0;
      row(i) = (lower - same) * intervals;
    }
  }
  return row;
}

Eigen::MatrixXd roughness_factor(int intervals) {
  constexpr std::array<double, 3> nodes{-0.7745966692414834, 0.0, 0.7745966692414834};  // sqrt(3/5)
  constexpr std::array<double, 3> weights{5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  Eigen::MatrixXd d(3 * intervals, intervals + kSplineDegree);
  const double half = 0.5 / intervals;
  for (int i = 0; i < intervals; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto node = static_cast<std::size_t>(k);
      const double t = (2 * i + 1 + nodes[node]) * half;
      d.row(3 * i + k) = std::sqrt(weights[node] * half) * spline_row(intervals, t, 3);
    }
  }
  return d;
}

}  // namespace strobe::contact
