#include "common/contact/differentiation/cubic_fit.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

namespace strobe::contact {

namespace {

using Design = Eigen::Matrix<double, Eigen::Dynamic, 4>;
using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

Design powers(const Eigen::VectorXd& t) {
  Design a(t.size(), 4);
  a.col(0).setOnes();
  for (int power = 1; power < 4; ++power) a.col(power) = a.col(power - 1).cwiseProduct(t);
  return a;
}

/// That of the triangle R, whose singular values are those of A.
double condition_of(const Design& a) {
  const Eigen::Matrix4d r =
      a.colPivHouseholderQr().matrixR().topLeftCorner<4, 4>().triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::Matrix4d, Eigen::NoQRPreconditioner> svd(r);
  return svd.singularValues()(0) / svd.singularValues()(3);
}

/// G with (AᵀA)⁻¹ = G·Gᵀ from A·P = Q·R: P·R⁻¹.
Eigen::Matrix4d covariance_factor(const Eigen::ColPivHouseholderQR<Design>& qr) {
  const Eigen::Matrix4d r = qr.matrixR().topLeftCorner<4, 4>();
  const Eigen::Matrix4d inverse = r.triangularView<Eigen::Upper>().solve(Eigen::Matrix4d::Identity());
  return qr.colsPermutation() * inverse;
}

/// From coefficients of powers of u = (t - c)/h to those of powers of t.
Eigen::Matrix4d shift_matrix(double centre, double half_width) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = 1.0;
  for (int column = 1; column < 4; ++column)
    for (int row = 0; row <= column; ++row) {
      const double carried = row > 0 ? m(row - 1, column - 1) : 0.0;
      m(row, column) = (carried - centre * m(row, column - 1)) / half_width;
    }
  return m;
}

/// Row of the `order`-th derivative with respect to u of 1, u, u², u³.
Eigen::RowVector4d derivative_row(double u, int order) {
  Eigen::RowVector4d row = Eigen::RowVector4d::Zero();
  for (int power = order; power < 4; ++power) {
    double factor = 1.0;
    for (int k = 0; k < order; ++k) factor *= power - k;
    row(power) = factor * std::pow(u, power - order);
  }
  return row;
}

}  // namespace

double CubicFit::derivative(double t, int order) const {
  const Eigen::Map<const Eigen::Vector4d> local(local_.data());
  const double u = (t - centre_) / half_width_;
  return derivative_row(u, order).dot(local) / std::pow(half_width_, order);
}

ValueSd CubicFit::derivative_with_sd(double t, int order) const {
  const Eigen::Map<const RowMajor4> root(covariance_factor_.data());
  const double u = (t - centre_) / half_width_;
  const double spread = (derivative_row(u, order) * root).norm() / std::pow(half_width_, order);
  return {derivative(t, order), residual_sd.value_or(0.0) * spread};
}

Result<CubicFit> fit_cubic(std::span<const double> t, std::span<const double> y) {
  if (t.size() != y.size()) return fail("a cubic fit needs as many times as values");
  if (t.size() < 4) return fail("a cubic fit needs at least four rows");
  const auto n = static_cast<Eigen::Index>(t.size());
  const Eigen::VectorXd times = Eigen::Map<const Eigen::VectorXd>(t.data(), n);
  const Eigen::VectorXd values = Eigen::Map<const Eigen::VectorXd>(y.data(), n);
  if (!times.allFinite() || !values.allFinite()) return fail("a cubic fit needs finite numbers");

  CubicFit fit;
  fit.n = static_cast<int>(n);
  fit.centre_ = 0.5 * times.minCoeff() + 0.5 * times.maxCoeff();
  fit.half_width_ = 0.5 * times.maxCoeff() - 0.5 * times.minCoeff();
  if (!(fit.half_width_ > 0.0)) return fail("a cubic fit needs four different times");
  const Design a = powers((times.array() - fit.centre_) / fit.half_width_);
  const Eigen::ColPivHouseholderQR<Design> qr(a);
  if (qr.rank() < 4) return fail("a cubic fit needs four different times");

  // About the middle of their range, so that equal values leave residuals of exactly zero.
  const double middle = 0.5 * values.minCoeff() + 0.5 * values.maxCoeff();
  const Eigen::VectorXd about = values.array() - middle;
  Eigen::Vector4d local = qr.solve(about);
  const double residual = (about - a * local).squaredNorm();
  const double total = (about.array() - about.mean()).matrix().squaredNorm();
  local(0) += middle;

  const Eigen::Matrix4d root = covariance_factor(qr);
  const Eigen::Matrix4d shift = shift_matrix(fit.centre_, fit.half_width_);
  const Eigen::Vector4d coefficients = shift * local;
  if (!shift.allFinite() || !coefficients.allFinite() || !std::isfinite(residual) || !std::isfinite(total))
    return fail("a cubic fit's numbers are beyond double precision");
  Eigen::Map<Eigen::Vector4d>(fit.local_.data()) = local;
  Eigen::Map<Eigen::Vector4d>(fit.coefficients.data()) = coefficients;
  Eigen::Map<RowMajor4>(fit.covariance_factor_.data()) = root;
  if (total > 0.0) fit.r_squared = 1.0 - residual / total;
  if (n > 4) {
    fit.residual_sd = std::sqrt(residual / static_cast<double>(n - 4));
    const Eigen::Vector4d errors = *fit.residual_sd * (shift * root).rowwise().norm();
    fit.standard_errors.emplace();
    Eigen::Map<Eigen::Vector4d>(fit.standard_errors->data()) = errors;
  }
  const Design monomial = powers(times);
  if (monomial.allFinite())
    fit.condition = {condition_of(monomial), condition_of(monomial.colwise().normalized()), condition_of(a)};
  return fit;
}

}  // namespace strobe::contact
