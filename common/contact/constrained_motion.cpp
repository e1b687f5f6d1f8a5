#include "common/contact/constrained_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <vector>

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

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Counting each degree of freedom 1.4 times keeps GCV from following the noise of few images (Kim and Gu).
constexpr double kDegreesWeight = 1.4;
/// Degrees of freedom.
constexpr double kMinTold = 0.5;

Result<void> check(std::span<const double> t, std::span<const double> y, const EndConditions& e,
                   const SplineOptions& o) {
  if (t.size() != y.size()) return fail("a constrained fit needs as many times as values");
  const auto finite = [](double v) { return std::isfinite(v) && std::abs(v) < 1e100; };
  for (const double v : y)
    if (!finite(v)) return fail("a constrained fit needs finite numbers below 1e100");
  for (const double v : {e.value_td, e.value_lo, e.slope_td.value, e.slope_lo.value, e.slope_td.sd,
                         e.slope_lo.sd, o.noise_sd.value_or(0.0), o.smoothing.value_or(1.0)})
    if (!finite(v)) return fail("a constrained fit needs finite numbers below 1e100");
  for (const double v : t)
    if (!(v >= 0.0 && v <= 1.0)) return fail("a constrained fit needs time fractions from 0 to 1");
  if (std::set<double>(t.begin(), t.end()).size() < 3)
    return fail("a constrained fit needs images at three different times");
  if (o.intervals < 1 || o.intervals > 32) return fail("a constrained fit takes 1 to 32 intervals");
  if (o.noise_sd && *o.noise_sd <= 0.0) return fail("the noise of a constrained fit must be positive");
  if (o.smoothing && *o.smoothing <= 0.0) return fail("the smoothing of a constrained fit must be positive");
  if (e.slope_td.sd < 0.0 || e.slope_lo.sd < 0.0) return fail("an sd must not be negative");
  return {};
}

/// One solution for one smoothing weight.
struct Solution {
  VectorXd free;  ///< coordinates in the constraints' null space
  double rss = 0.0;
  double parameters = 0.0;
  MatrixXd r;  ///< upper triangle of the stacked system
};

}  // namespace

class SplineFitter {
 public:
  SplineFitter(std::span<const double> t, std::span<const double> y, const EndConditions& ends,
               const SplineOptions& options)
      : ends_(ends), options_(options), n_(static_cast<Eigen::Index>(t.size())) {
    const int m = options.intervals;
    images_.resize(n_, m + kSplineDegree);
    for (Eigen::Index i = 0; i < n_; ++i) images_.row(i) = spline_row(m, t[static_cast<std::size_t>(i)], 0);
    values_ = Eigen::Map<const VectorXd>(y.data(), n_);
    roughness_ = roughness_factor(m);
    constrain();
    reduced_images_ = images_ * null_space_;
    reduced_roughness_ = roughness_ * null_space_;
  }

  ConstrainedSpline fit() const {
    const double weight = options_.smoothing.value_or(0.0) > 0.0 ? *options_.smoothing : best_weight();
    const VectorXd particular = particulars_ * targets_;
    const Solution s = solve(weight, particular, values_);
    const double freedom = static_cast<double>(n_) - s.parameters;
    ConstrainedSpline out;
    out.intervals_ = options_.intervals;
    out.n_ = static_cast<int>(n_);
    out.smoothing_ = weight;
    out.residual_sd_ = freedom > 0.0 ? std::sqrt(s.rss / freedom) : 0.0;
    const VectorXd c = particular + null_space_ * s.free;
    out.coefficients_.assign(c.begin(), c.end());
    const MatrixXd inverse =
        s.r.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(s.r.rows(), s.r.cols()));
    const bool told = options_.smoothing || s.parameters >= kMinTold;
    const MatrixXd root = (told ? options_.noise_sd.value_or(out.residual_sd_) : 0.0) * null_space_ * inverse;
    out.covariance_factor_.assign(root.reshaped().begin(), root.reshaped().end());
    for (const auto& [row, sd] : {std::pair{2, ends_.slope_td.sd}, std::pair{3, ends_.slope_lo.sd}}) {
      const VectorXd change = particulars_.col(row) * (told ? sd : 0.0);
      const VectorXd moved = change + null_space_ * solve(weight, change, VectorXd::Zero(n_)).free;
      out.end_slope_factor_.insert(out.end_slope_factor_.end(), moved.begin(), moved.end());
    }
    return out;
  }

 private:
  /// Coefficients that meet the constraints: particulars_·targets_ + null_space_·anything.
  void constrain() {
    const int m = options_.intervals;
    const Eigen::Index rows = ends_.no_force_at_ends ? 6 : 4;
    MatrixXd c(rows, m + kSplineDegree);
    targets_ = VectorXd::Zero(rows);
    targets_.head(4) << ends_.value_td, ends_.value_lo, ends_.slope_td.value, ends_.slope_lo.value;
    for (int row = 0; row < rows; ++row) c.row(row) = spline_row(m, row % 2, row / 2);
    const Eigen::HouseholderQR<MatrixXd> qr(c.transpose());
    const MatrixXd q = qr.householderQ();
    const MatrixXd r = qr.matrixQR().topRows(rows);
    particulars_ =
        q.leftCols(rows) * r.triangularView<Eigen::Upper>().transpose().solve(MatrixXd::Identity(rows, rows));
    null_space_ = q.rightCols(q.cols() - rows);
  }

  Solution solve(double weight, const VectorXd& particular, const VectorXd& values) const {
    const double root = std::sqrt(weight);
    MatrixXd stacked(reduced_images_.rows() + reduced_roughness_.rows(), null_space_.cols());
    stacked << reduced_images_, root * reduced_roughness_;
    VectorXd right(stacked.rows());
    right << values - images_ * particular, -root * (roughness_ * particular);
    const Eigen::HouseholderQR<MatrixXd> qr(stacked);
    const Eigen::Index p = stacked.cols();
    const MatrixXd thin = qr.householderQ() * MatrixXd::Identity(stacked.rows(), p);
    Solution s;
    s.r = qr.matrixQR().topRows(p);
    s.free = s.r.triangularView<Eigen::Upper>().solve(thin.transpose() * right);
    s.rss = (right.head(n_) - reduced_images_ * s.free).squaredNorm();
    s.parameters = thin.topRows(n_).squaredNorm();
    return s;
  }

  /// What the choice of the weight makes small.
  double criterion(double weight) const {
    const Solution s = solve(weight, particulars_ * targets_, values_);
    const auto n = static_cast<double>(n_);
    if (options_.noise_sd) return s.rss + 2.0 * *options_.noise_sd * *options_.noise_sd * s.parameters;
    const double left = n - kDegreesWeight * s.parameters;
    return left > 0.0 ? s.rss / (left * left) : std::numeric_limits<double>::infinity();
  }

  /// Smallest over a grid of decades' quarters, then by golden section between its neighbours.
  double best_weight() const {
    constexpr double kLowest = -10.0, kHighest = 2.0, kStep = 0.25;
    double best = kHighest, smallest = std::numeric_limits<double>::infinity();
    for (double decade = kHighest; decade >= kLowest; decade -= kStep) {
      const double value = criterion(std::pow(10.0, decade));
      if (value < smallest) {
        smallest = value;
        best = decade;
      }
    }
    constexpr double kGolden = 0.6180339887498949;
    double low = std::max(kLowest, best - kStep), high = std::min(kHighest, best + kStep);
    for (int i = 0; i < 20; ++i) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      criterion(std::pow(10.0, a)) < criterion(std::pow(10.0, b)) ? high = b : low = a;
    }
    return std::pow(10.0, 0.5 * (low + high));
  }

  EndConditions ends_;
  SplineOptions options_;
  Eigen::Index n_;
  MatrixXd images_, roughness_, particulars_, null_space_, reduced_images_, reduced_roughness_;
  VectorXd values_, targets_;
};

ValueSd ConstrainedSpline::derivative_with_sd(double t, int order) const {
  const Eigen::RowVectorXd row = spline_row(intervals_, std::clamp(t, 0.0, 1.0), order);
  const Eigen::Index rows = row.size();
  const auto columns = [rows](const std::vector<double>& data) {
    return Eigen::Map<const MatrixXd>(data.data(), rows, static_cast<Eigen::Index>(data.size()) / rows);
  };
  const double value = row.dot(columns(coefficients_).col(0));
  return {value,
          std::hypot((row * columns(covariance_factor_)).norm(), (row * columns(end_slope_factor_)).norm())};
}

Result<ConstrainedSpline> fit_constrained_spline(std::span<const double> t, std::span<const double> y,
                                                 const EndConditions& ends, const SplineOptions& options) {
  if (const auto ok = check(t, y, ends, options); !ok) return tl::unexpected(ok.error());
  return SplineFitter(t, y, ends, options).fit();
}

namespace {

ValueSd times(const ValueSd& v, double factor) { return {v.value * factor, v.sd * std::abs(factor)}; }

std::optional<ConstrainedSpline> fitted(const std::vector<double>& t, const std::vector<double>& y,
                                        const EndConditions& ends, const SplineOptions& options) {
  auto fit = fit_constrained_spline(t, y, ends, options);
  if (!fit) return std::nullopt;
  return *std::move(fit);
}

std::optional<ValueSd> scaled(const std::optional<ConstrainedSpline>& fit, double t, int order,
                              double factor) {
  if (!fit) return std::nullopt;
  return times(fit->derivative_with_sd(t, order), factor);
}

}  // namespace

Result<void> check(const ContactScale& s) {
  if (!(std::isfinite(s.dwell_time_s) && s.dwell_time_s > 0.0)) return fail("dwell time must be positive");
  if (!(std::isfinite(s.dwell_distance_m) && s.dwell_distance_m > 0.0))
    return fail("dwell distance must be positive");
  if (!(std::isfinite(s.diameter_m) && s.diameter_m > 0.0)) return fail("diameter must be positive");
  if (!(std::isfinite(s.mass_kg) && s.mass_kg > 0.0)) return fail("mass must be positive");
  if (!std::isfinite(s.total_rotation_rad)) return fail("total rotation must be a finite number");
  return {};
}

Result<ConstrainedMotion> fit_constrained_motion(const data::ContactSet& set, const ContactScale& s,
                                                 const EndVelocities& ends, bool no_force,
                                                 const SplineOptions& options) {
  if (const auto ok = check(s); !ok) return tl::unexpected(ok.error());
  std::vector<double> t, x, y, t_rotation, rotation;
  for (const data::ContactRow& row : set.rows) {
    if (!data::is_interior(row)) continue;
    t.push_back(row.time_fraction);
    x.push_back(row.x_fraction * s.dwell_distance_m);
    y.push_back(row.y_fraction * s.diameter_m);
    if (!row.rotation_fraction) continue;
    t_rotation.push_back(row.time_fraction);
    rotation.push_back(*row.rotation_fraction * s.total_rotation_rad);
  }
  const double dwell = s.dwell_time_s;
  const EndConditions along{0.0, s.dwell_distance_m, times(ends.vx_td_mps, dwell),
                            times(ends.vx_lo_mps, dwell), no_force};
  const EndConditions normal{0.0, 0.0, times(ends.vy_td_mps, dwell), times(ends.vy_lo_mps, dwell), no_force};
  const EndConditions turn{0.0, s.total_rotation_rad, times(ends.omega_td_radps, dwell),
                           times(ends.omega_lo_radps, dwell), no_force};
  return ConstrainedMotion{fitted(t, x, along, options), fitted(t, y, normal, options),
                           fitted(t_rotation, rotation, turn, options), s};
}

DerivedState derive(const ConstrainedMotion& m, double t) {
  const ContactScale& s = m.scale;
  const double rate = 1.0 / s.dwell_time_s, rate2 = rate * rate;
  DerivedState out{.x_m = scaled(m.x, t, 0, 1.0),
                   .y_m = scaled(m.y, t, 0, 1.0),
                   .rotation_rad = scaled(m.rotation, t, 0, 1.0),
                   .vx_mps = scaled(m.x, t, 1, rate),
                   .vy_mps = scaled(m.y, t, 1, rate),
                   .omega_radps = scaled(m.rotation, t, 1, rate),
                   .fx_n = scaled(m.x, t, 2, s.mass_kg * rate2),
                   .fy_n = scaled(m.y, t, 2, s.mass_kg * rate2),
                   .torque_nm = scaled(m.rotation, t, 2, s.inertia_kgm2() * rate2),
                   .slip_mps = std::nullopt};
  out.slip_mps = slip_of(out, 0.5 * s.diameter_m);
  return out;
}

std::optional<ForcePeak> largest_normal_force(const ConstrainedMotion& motion) {
  if (!motion.y) return std::nullopt;
  constexpr int kSteps = 1000;
  int best = 0;
  for (int i = 1; i <= kSteps; ++i)
    if (motion.y->curvature(static_cast<double>(i) / kSteps) >
        motion.y->curvature(static_cast<double>(best) / kSteps))
      best = i;
  const double fraction = static_cast<double>(best) / kSteps;
  return ForcePeak{*derive(motion, fraction).fy_n, fraction};
}

}  // namespace strobe::contact
