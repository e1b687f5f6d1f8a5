#include "common/contact/cubic_fit.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace strobe::contact {

namespace {

using Design = Eigen::Matrix<double, Eigen::Dynamic, 4>;

Design design_matrix(const Eigen::VectorXd& t) {
  Design a(t.size(), 4);
  a.col(0).setOnes();
  for (int power = 1; power < 4; ++power) a.col(power) = a.col(power - 1).cwiseProduct(t);
  return a;
}

/// diag((AᵀA)⁻¹) from A·P = Q·R, as the squared row norms of P·R⁻¹.
Eigen::Vector4d unit_variances(const Eigen::ColPivHouseholderQR<Design>& qr) {
  const Eigen::Matrix4d r = qr.matrixR().topLeftCorner<4, 4>();
  const Eigen::Matrix4d inverse = r.triangularView<Eigen::Upper>().solve(Eigen::Matrix4d::Identity());
  const Eigen::Matrix4d unpivoted = qr.colsPermutation() * inverse;
  return unpivoted.rowwise().squaredNorm();
}

}  // namespace

double CubicFit::value(double t) const {
  const auto& c = coefficients;
  return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
}

double CubicFit::slope(double t) const {
  return coefficients[1] + t * (2.0 * coefficients[2] + t * 3.0 * coefficients[3]);
}

double CubicFit::curvature(double t) const { return 2.0 * coefficients[2] + 6.0 * t * coefficients[3]; }

Result<CubicFit> fit_cubic(std::span<const double> t, std::span<const double> y) {
  if (t.size() != y.size()) return fail("a cubic fit needs as many times as values");
  if (t.size() < 4) return fail("a cubic fit needs at least four rows");
  const auto n = static_cast<Eigen::Index>(t.size());
  const Eigen::VectorXd times = Eigen::Map<const Eigen::VectorXd>(t.data(), n);
  const Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(y.data(), n);
  if (!times.allFinite() || !values.allFinite()) return fail("a cubic fit needs finite numbers");

  const Design a = design_matrix(times);
  const Eigen::ColPivHouseholderQR<Design> qr(a);
  if (qr.rank() < 4) return fail("a cubic fit needs four different times");
  const Eigen::Vector4d solution = qr.solve(values);
  const double residual = (values - a * solution).squaredNorm();
  const double total = (values.array() - values.mean()).matrix().squaredNorm();

  CubicFit fit;
  fit.n = static_cast<int>(n);
  Eigen::Map<Eigen::Vector4d>(fit.coefficients.data()) = solution;
  if (total > 0.0) fit.r_squared = 1.0 - residual / total;
  if (n > 4) {
    const Eigen::Vector4d errors = (unit_variances(qr) * (residual / static_cast<double>(n - 4))).cwiseSqrt();
    fit.standard_errors.emplace();
    Eigen::Map<Eigen::Vector4d>(fit.standard_errors->data()) = errors;
  }
  return fit;
}

}  // namespace strobe::contact
