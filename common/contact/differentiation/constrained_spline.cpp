#include "common/contact/differentiation/constrained_spline.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/contact/differentiation/uniform_spline.hpp"

namespace strobe::contact {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Counting each degree of freedom 1.4 times keeps GCV from following the noise of few images (Kim and Gu).
constexpr double kDegreesWeight = 1.4;

Result<void> check(std::span<const double> t, std::span<const double> y, const EndConditions& e,
                   const SplineOptions& o) {
  if (t.size() != y.size()) return fail("a constrained fit needs as many times as values");
  if (t.size() < 3) return fail("a constrained fit needs at least three images");
  const auto finite = [](double v) { return std::isfinite(v) && std::abs(v) < 1e100; };
  for (const double v : y)
    if (!finite(v)) return fail("a constrained fit needs finite numbers below 1e100");
  for (const double v : {e.value_td, e.value_lo, e.slope_td.value, e.slope_lo.value, e.slope_td.sd,
                         e.slope_lo.sd, o.noise_sd.value_or(0.0), o.smoothing.value_or(1.0)})
    if (!finite(v)) return fail("a constrained fit needs finite numbers below 1e100");
  for (const double v : t)
    if (!(v >= 0.0 && v <= 1.0)) return fail("a constrained fit needs time fractions from 0 to 1");
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
    const MatrixXd root = options_.noise_sd.value_or(out.residual_sd_) * null_space_ * inverse;
    out.covariance_factor_.assign(root.reshaped().begin(), root.reshaped().end());
    for (const auto& [row, sd] : {std::pair{2, ends_.slope_td.sd}, std::pair{3, ends_.slope_lo.sd}}) {
      const VectorXd change = particulars_.col(row) * sd;
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

}  // namespace strobe::contact
