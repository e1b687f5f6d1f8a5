#include "common/contact/differentiation.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
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
  if (n > 4 && std::sqrt(residual) > data::kRounding * about.norm()) {
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

namespace {

std::optional<CubicFit> fitted(std::span<const double> t, std::span<const double> y) {
  auto fit = fit_cubic(t, y);
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

std::optional<ValueSd> scaled(const std::optional<CubicFit>& fit, double t, int order, double factor) {
  if (!fit) return std::nullopt;
  const ValueSd v = fit->derivative_with_sd(t, order);
  return ValueSd{v.value * factor, v.sd * std::abs(factor)};
}

std::optional<std::array<double, 3>> slope_of(const std::optional<CubicFit>& fit, double factor) {
  if (!fit) return std::nullopt;
  const auto& c = fit->coefficients;
  return std::array{factor * c[1], factor * 2.0 * c[2], factor * 3.0 * c[3]};
}

std::optional<std::array<double, 2>> curvature_of(const std::optional<CubicFit>& fit, double factor) {
  if (!fit) return std::nullopt;
  const auto& c = fit->coefficients;
  return std::array{factor * 2.0 * c[2], factor * 6.0 * c[3]};
}

DerivedPolynomials polynomials(const FractionFits& f, double x, double y, double turn, double rate,
                               double mass, double inertia) {
  const double rate2 = rate * rate;
  return {.vx_mps = slope_of(f.x, x * rate),
          .vy_mps = slope_of(f.y, y * rate),
          .omega_radps = slope_of(f.rotation, turn * rate),
          .fx_n = curvature_of(f.x, mass * x * rate2),
          .fy_n = curvature_of(f.y, mass * y * rate2),
          .torque_nm = curvature_of(f.rotation, inertia * turn * rate2)};
}

/// The cubic's sign changes between its turning points, by bisection: to the last bit, without cancellation.
std::vector<double> sign_changes(const CubicFit& fit, double low, double high) {
  const auto& c = fit.coefficients;
  std::vector<double> knots{low};
  for (const double t : quadratic_roots({c[1], 2.0 * c[2], 3.0 * c[3]}, low, high)) knots.push_back(t);
  knots.push_back(high);
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    double a = knots[i], b = knots[i + 1];
    const bool rising = fit.value(b) > fit.value(a);
    if ((fit.value(a) > 0.0) == (fit.value(b) > 0.0)) continue;
    for (int k = 0; k < 200 && a < b; ++k) {
      const double middle = 0.5 * (a + b);
      if (middle <= a || middle >= b) break;
      ((fit.value(middle) > 0.0) == rising ? b : a) = middle;
    }
    roots.push_back(0.5 * (a + b));
  }
  return roots;
}

}  // namespace

FractionFits fit_fractions(const data::ContactSet& set) {
  std::vector<double> t, x, y, t_rotation, rotation;
  for (const data::ContactRow& row : set.rows) {
    t.push_back(row.time_fraction);
    x.push_back(row.x_fraction);
    y.push_back(row.y_fraction);
    if (!row.rotation_fraction) continue;
    t_rotation.push_back(row.time_fraction);
    rotation.push_back(*row.rotation_fraction);
  }
  return {fitted(t, x), fitted(t, y), fitted(t_rotation, rotation)};
}

std::optional<ValueSd> slip_of(const DerivedState& state, double radius_m) {
  if (!state.vx_mps || !state.omega_radps) return std::nullopt;
  return ValueSd{state.vx_mps->value + radius_m * state.omega_radps->value,
                 std::hypot(state.vx_mps->sd, radius_m * state.omega_radps->sd)};
}

DerivedState derive(const FractionFits& fits, const ContactScale& s, double t) {
  const double rate = 1.0 / s.dwell_time_s, rate2 = rate * rate;
  const double x = s.dwell_distance_m, y = s.diameter_m, turn = s.total_rotation_rad;
  DerivedState out{.x_m = scaled(fits.x, t, 0, x),
                   .y_m = scaled(fits.y, t, 0, y),
                   .rotation_rad = scaled(fits.rotation, t, 0, turn),
                   .vx_mps = scaled(fits.x, t, 1, x * rate),
                   .vy_mps = scaled(fits.y, t, 1, y * rate),
                   .omega_radps = scaled(fits.rotation, t, 1, turn * rate),
                   .fx_n = scaled(fits.x, t, 2, s.mass_kg * x * rate2),
                   .fy_n = scaled(fits.y, t, 2, s.mass_kg * y * rate2),
                   .torque_nm = scaled(fits.rotation, t, 2, s.inertia_kgm2() * turn * rate2),
                   .slip_mps = std::nullopt};
  out.slip_mps = slip_of(out, 0.5 * s.diameter_m);
  return out;
}

DerivedPolynomials derived_polynomials(const FractionFits& fits, const ContactScale& s) {
  return polynomials(fits, s.dwell_distance_m, s.diameter_m, s.total_rotation_rad, 1.0 / s.dwell_time_s,
                     s.mass_kg, s.inertia_kgm2());
}

DerivedPolynomials fraction_polynomials(const FractionFits& fits) {
  return polynomials(fits, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0);
}

std::vector<double> quadratic_roots(const std::array<double, 3>& c, double low, double high) {
  std::vector<double> roots;
  const auto keep = [&](double t) {
    if (std::isfinite(t) && t >= low && t <= high) roots.push_back(t);
  };
  const double half = -0.5 * c[1];
  const double discriminant = half * half - c[0] * c[2];
  if (discriminant < 0.0) return roots;
  // The root of larger magnitude first; the other from the product: no difference of near equals.
  const double q = half + std::copysign(std::sqrt(discriminant), half);
  if (c[2] != 0.0) keep(q / c[2]);
  if (q != 0.0 && discriminant > 0.0) keep(c[0] / q);
  std::sort(roots.begin(), roots.end());
  return roots;
}

ZeroCrossings zero_crossings(const FractionFits& fits, const ContactScale& scale) {
  ZeroCrossings out;
  const DerivedPolynomials p = derived_polynomials(fits, scale);
  if (fits.rotation) {
    // The fit's constant is not quite zero: its crossing beside touchdown is that of an end point.
    constexpr double kBesideTouchdown = 0.02;
    out.rotation = sign_changes(*fits.rotation, kBesideTouchdown, 1.0);
  }
  if (p.omega_radps) out.omega = quadratic_roots(*p.omega_radps, 0.0, 1.0);
  if (p.omega_radps && p.vx_mps) {
    std::array<double, 3> slip{};
    for (std::size_t i = 0; i < 3; ++i)
      slip[i] = (*p.vx_mps)[i] + 0.5 * scale.diameter_m * (*p.omega_radps)[i];
    out.slip = quadratic_roots(slip, 0.0, 1.0);
  }
  return out;
}

std::optional<ErrorGrowth> error_growth(const CubicFit& fit) {
  if (!fit.residual_sd) return std::nullopt;
  constexpr int kSteps = 200;
  std::array<double, 3> value{}, sd{};
  for (int i = 0; i <= kSteps; ++i) {
    for (int order = 0; order < 3; ++order) {
      const ValueSd v = fit.derivative_with_sd(static_cast<double>(i) / kSteps, order);
      value[static_cast<std::size_t>(order)] += v.value * v.value;
      sd[static_cast<std::size_t>(order)] += v.sd * v.sd;
    }
  }
  if (!(value[0] > 0.0 && value[1] > 0.0 && value[2] > 0.0)) return std::nullopt;
  const double ends = std::max(fit.derivative_with_sd(0.0, 2).sd, fit.derivative_with_sd(1.0, 2).sd);
  return ErrorGrowth{.position = std::sqrt(sd[0] / value[0]),
                     .velocity = std::sqrt(sd[1] / value[1]),
                     .force = std::sqrt(sd[2] / value[2]),
                     .force_at_ends = ends / std::sqrt(value[2] / (kSteps + 1))};
}

}  // namespace strobe::contact
