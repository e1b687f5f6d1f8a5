#include "host/commission/balls/free_fall.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "common/flight/aerodynamics.hpp"
#include "common/geometry/line.hpp"
#include "host/commission/core/least_squares.hpp"

namespace strobe::commission {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kMinOfLeg = 3;  // of a leg
constexpr double kOutlier_sd = 5.0;
constexpr int kIterations = 8;
constexpr double kDragShareSd = flight::kDragCoefficientSd / flight::kDragCoefficient;
/// Centres that state less are not better known: texture and light move a centre by some hundredths of a pixel.
constexpr double kMinCentreSd_px = 0.02;

struct Point {
  double time_s = 0.0;  ///< from the leg's mean
  Vector2d place_m = Vector2d::Zero();
  Matrix2d weight = Matrix2d::Identity();  ///< Cholesky factor of the inverse covariance, transposed
  std::size_t of = 0;
};

struct Flown {
  std::vector<Point> points;
};

struct Axes {
  Vector2d origin_px, along, up;
};

std::optional<Axes> axes_of(const reduction::Frame& frame) {
  std::vector<Vector2d> points;
  for (const auto& p : frame.surface_px) points.emplace_back(p.x, p.y);
  const auto line = geometry::fit_line(points);
  if (!line) return std::nullopt;
  Vector2d along = line->direction();
  if (along.x() < 0.0) along = -along;
  return Axes{line->origin(), along, Vector2d(-along.y(), along.x())};
}

Matrix2d covariance_px2(const reduction::Frame& frame, const reduction::BallImage& image) {
  Matrix2d c;
  if (image.centre_cov_px2) {
    const auto& v = *image.centre_cov_px2;
    c << v[0], v[1], v[2], v[3];
  } else {
    const double sd = frame.centre_sd_px.value_or(0.3);
    c = sd * sd * Matrix2d::Identity();
  }
  return c + kMinCentreSd_px * kMinCentreSd_px * Matrix2d::Identity();
}

/// Cholesky's: u with transpose(u) u = m.
Matrix2d upper_factor(const Matrix2d& m) {
  const double first = std::sqrt(m(0, 0)), across = m(1, 0) / first;
  Matrix2d u;
  u << first, across, 0.0, std::sqrt(m(1, 1) - across * across);
  return u;
}

void add_legs(const reduction::Frame& frame, double px_per_m, std::vector<Flown>& legs) {
  const auto axes = axes_of(frame);
  if (!axes) return;
  Matrix2d turn;
  turn.row(0) = axes->along.transpose() / px_per_m;
  turn.row(1) = axes->up.transpose() / px_per_m;
  for (const Leg which : {Leg::incoming, Leg::rebound}) {
    Flown leg;
    double sum_s = 0.0;
    for (const reduction::BallImage& image : frame.images) {
      if (image.leg != which || image.other_leg) continue;
      const Matrix2d covariance = turn * covariance_px2(frame, image) * turn.transpose();
      Point point;
      point.time_s = image.time_s;
      point.place_m = turn * (Vector2d(image.centre_px.x, image.centre_px.y) - axes->origin_px);
      point.weight = upper_factor(covariance.inverse());
      sum_s += image.time_s;
      leg.points.push_back(point);
    }
    if (static_cast<int>(leg.points.size()) < kMinOfLeg) continue;
    for (Point& point : leg.points) point.time_s -= sum_s / static_cast<double>(leg.points.size());
    legs.push_back(std::move(leg));
  }
}

/// Common: gravity along and up, the share of drag. Then of each leg: place and velocity at its mean time.
constexpr int kCommon = 3, kOfLeg = 4;

class Fit {
 public:
  Fit(std::vector<Flown> legs, const flight::Aerodynamics& air) : legs_(std::move(legs)), air_(air) {
    parameters_ = VectorXd::Zero(kCommon + kOfLeg * static_cast<int>(legs_.size()));
    parameters_[1] = -flight::kStandardGravity_mps2;
    parameters_[2] = 1.0;
    for (std::size_t i = 0; i < legs_.size(); ++i) start(i);
  }

  void solve() {
    for (int i = 0; i < kIterations; ++i) {
      linearize();
      parameters_ += step_;
    }
    linearize();
  }

  /// Leaves the worst image out; false: none is so far off.
  bool drop_outlier() {
    const double usual = typical();
    double worst = kOutlier_sd;
    std::size_t leg = 0, point = 0;
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      if (static_cast<int>(legs_[i].points.size()) <= kMinOfLeg) continue;
      for (std::size_t k = 0; k < legs_[i].points.size(); ++k) {
        const double off = residual(i, k, parameters_).norm() / usual;
        if (off > worst) worst = off, leg = i, point = k;
      }
    }
    if (worst <= kOutlier_sd) return false;
    auto& points = legs_[leg].points;
    points.erase(points.begin() + static_cast<std::ptrdiff_t>(point));
    return true;
  }

  FreeFall result() const {
    FreeFall found;
    const Vector2d g = parameters_.head<2>();
    // More scatter than stated: as much more uncertain (Birge's ratio).
    found.degrees_of_freedom = rows_ - static_cast<int>(parameters_.size());
    found.chi_squared = chi_squared_;
    const double birge = std::max(1.0, chi_squared_ / std::max(1, found.degrees_of_freedom));
    const MatrixXd covariance = birge * information_.inverse();
    found.g_mps2 = g.norm();
    const Vector2d unit = g.normalized(), across(-unit.y(), unit.x());
    const Matrix2d of_g = covariance.topLeftCorner<2, 2>();
    found.g_sd_mps2 = std::sqrt(unit.dot(of_g * unit));
    found.inclination_rad = std::atan2(-g.x(), -g.y());
    found.inclination_sd_rad = std::sqrt(across.dot(of_g * across)) / found.g_mps2;
    found.drag_share = parameters_[2];
    found.legs = static_cast<int>(legs_.size());
    for (const Flown& leg : legs_) found.images += static_cast<int>(leg.points.size());
    return found;
  }

 private:
  void start(std::size_t i) {
    const std::vector<Point>& points = legs_[i].points;
    Vector2d mean = Vector2d::Zero(), slope = Vector2d::Zero();
    double moment = 0.0;
    for (const Point& p : points) mean += p.place_m;
    mean /= static_cast<double>(points.size());
    for (const Point& p : points) slope += p.time_s * (p.place_m - mean), moment += p.time_s * p.time_s;
    const int at = kCommon + kOfLeg * static_cast<int>(i);
    parameters_.segment<2>(at) = mean;
    parameters_.segment<2>(at + 2) = moment > 0.0 ? Vector2d(slope / moment) : Vector2d(Vector2d::Zero());
  }

  /// In sds.
  Vector2d residual(std::size_t leg, std::size_t point, const VectorXd& of) const {
    const int at = kCommon + kOfLeg * static_cast<int>(leg);
    flight::Aerodynamics air = air_;
    air.drag_per_m *= of[2];
    const Vector2d velocity = of.segment<2>(at + 2);
    const flight::Flight path{of.segment<2>(at), velocity, flight::forcing(air, of.head<2>(), velocity, 0.0)};
    const Point& p = legs_[leg].points[point];
    return p.weight * (p.place_m - path.position_at(p.time_s));
  }

  /// Of a residual in sds, by the median: the outliers themselves do not hide each other.
  double typical() const {
    constexpr double kMedianOfTwo = 1.1774;  // of the length of two standard normals (Rayleigh)
    std::vector<double> sizes;
    for (std::size_t i = 0; i < legs_.size(); ++i)
      for (std::size_t k = 0; k < legs_[i].points.size(); ++k)
        sizes.push_back(residual(i, k, parameters_).norm());
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    return std::max(1.0, *middle / kMedianOfTwo);
  }

  void linearize() {
    const auto size = parameters_.size();
    information_ = MatrixXd::Zero(size, size);
    VectorXd pull = VectorXd::Zero(size);
    chi_squared_ = 0.0;
    rows_ = 1;  // the prior of the drag
    information_(2, 2) = 1.0 / (kDragShareSd * kDragShareSd);
    pull[2] = (1.0 - parameters_[2]) / (kDragShareSd * kDragShareSd);
    for (std::size_t i = 0; i < legs_.size(); ++i) {
      for (std::size_t k = 0; k < legs_[i].points.size(); ++k) {
        const Vector2d r = residual(i, k, parameters_);
        const MatrixXd jacobian = derivative(i, k);
        information_ += jacobian.transpose() * jacobian;
        pull += jacobian.transpose() * r;
        chi_squared_ += r.squaredNorm();
        rows_ += 2;
      }
    }
    step_ = solve_normal(information_, pull);
  }

  /// Of the model, by differences: it is smooth, and all but linear.
  MatrixXd derivative(std::size_t leg, std::size_t point) const {
    MatrixXd jacobian = MatrixXd::Zero(2, parameters_.size());
    const int at = kCommon + kOfLeg * static_cast<int>(leg);
    const auto column = [&](int parameter) {
      constexpr double kStep = 1e-5;
      VectorXd moved = parameters_;
      moved[parameter] += kStep;
      const Vector2d more = residual(leg, point, moved);
      moved[parameter] -= 2.0 * kStep;
      jacobian.col(parameter) = (residual(leg, point, moved) - more) / (2.0 * kStep);
    };
    for (int i = 0; i < kCommon; ++i) column(i);
    for (int i = 0; i < kOfLeg; ++i) column(at + i);
    return jacobian;
  }

  std::vector<Flown> legs_;
  flight::Aerodynamics air_;
  VectorXd parameters_, step_;
  MatrixXd information_;
  double chi_squared_ = 0.0;
  int rows_ = 0;
};

}  // namespace

Result<FreeFall> measure_free_fall(std::span<const reduction::Frame> frames, const ball::Ball& ball,
                                   double px_per_m) {
  std::vector<Flown> legs;
  double density_kgpm3 = flight::kAirDensity_kgpm3;
  for (const reduction::Frame& frame : frames) {
    add_legs(frame, px_per_m, legs);
    if (frame.temperature_c) density_kgpm3 = flight::air_density_kgpm3(*frame.temperature_c);
  }
  // Three images of one leg leave two residuals to three common unknowns.
  if (legs.empty()) return fail("no flight with three images or more");
  Fit fit(std::move(legs), flight::aerodynamics(ball, density_kgpm3));
  fit.solve();
  int outliers = 0;
  while (fit.drop_outlier()) {
    ++outliers;
    fit.solve();
  }
  FreeFall found = fit.result();
  if (found.degrees_of_freedom < 1) return fail("too few images of the flights to tell gravity");
  found.outliers = outliers;
  return found;
}

}  // namespace strobe::commission
