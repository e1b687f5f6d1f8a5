#include "common/sampling/sample.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace strobe::sampling {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd Sample::mean() const { return points * weights; }

MatrixXd Sample::covariance() const {
  const MatrixXd centred = points.colwise() - mean();
  return centred * weights.asDiagonal() * centred.transpose();
}

/// The values stand at the middles of their weights, linearly in between.
std::vector<double> Sample::quantiles(Index coordinate, const std::vector<double>& levels) const {
  std::vector<Index> order(static_cast<std::size_t>(points.cols()));
  std::iota(order.begin(), order.end(), Index{0});
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return points(coordinate, a) < points(coordinate, b); });
  std::vector<double> out;
  for (const double level : levels) {
    double below = 0.0, last_level = 0.0, last = points(coordinate, order.front()), found = last;
    for (const Index i : order) {
      const double at = below + 0.5 * weights[i], value = points(coordinate, i);
      found = value;
      if (at >= level) {
        if (at > last_level) found = last + (value - last) * (level - last_level) / (at - last_level);
        break;
      }
      below += weights[i];
      last_level = at;
      last = value;
    }
    out.push_back(found);
  }
  return out;
}

double Sample::effective_size() const { return 1.0 / weights.squaredNorm(); }

Sample unweighted(MatrixXd points) {
  const auto n = static_cast<double>(points.cols());
  const Index count = points.cols();
  return {std::move(points), VectorXd::Constant(count, 1.0 / n)};
}

}  // namespace strobe::sampling
