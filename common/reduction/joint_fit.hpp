// Least squares fit of surface line, scale and both legs' flight to one photograph, by orthogonal
// factorization: each measurement is divided by its noise, reflections eliminate the four unknowns of either
// leg, and what is left of the images joins surface points, diameters and calibrated scale in a small
// triangle of tilt, height and scale. Normal equations, which square the condition, are never formed.
// Part of the reduction, not of its interface. Thread-safe; no allocation.
#pragma once

#include <array>

#include "common/flight/aerodynamics.hpp"
#include "common/reduction/factorization.hpp"
#include "common/reduction/observations.hpp"

namespace strobe::reduction {

/// Time is measured from a leg's mean in units of its length, so that every column is of order one.
struct LegTime {
  bool fitted = false;
  double origin_s = 0.0;
  double span_s = 1.0;
  double first_s = 0.0;
  double last_s = 0.0;
  double scaled(double time_s) const { return (time_s - origin_s) / span_s; }
};

/// What accelerates the ball: gravity in the surface's axes, air, and the legs' spins.
struct FlightModel {
  Eigen::Vector2d gravity_mps2 = Eigen::Vector2d::Zero();
  flight::Aerodynamics air;
  std::array<double, 2> omega_radps{};
  std::array<double, 2> more_lift_per_s{};  ///< see flight::forcing
};

/// Why an iteration ended.
enum class FitStatus {
  converged,
  iteration_limit,  ///< near enough to go on: what is left is no measurement's size
  degenerate,       ///< no scale, or no place, agrees with the measurements
};

struct JointFit {
  JointVector unknowns{};
  SquareRootInformation factor;  ///< the covariance's; zero rows for a leg that is not fitted
  std::array<LegTime, 2> legs;
  /// In the surface's axes at the leg's origin of time, as used.
  std::array<flight::Forcing, 2> forcing;
  FitStatus status = FitStatus::iteration_limit;
  bool air_used = true;  ///< false: the legs are too long or too fast for the law of the drag

  bool degenerate() const { return status == FitStatus::degenerate; }
};

constexpr std::size_t leg_index(Leg leg) { return leg == Leg::rebound ? 1 : 0; }

/// Gauss-Newton; the problem is linear but for products of small corrections. A leg with fewer than two
/// images is not fitted. Stops within a millionth of an sd, mostly after two steps.
JointFit fit_joint(const Observations& all, const FlightModel& model);

/// Inverse of the Cholesky factor of an image's covariance.
struct Whitening {
  double xx = 1.0;
  double yx = 0.0;
  double yy = 1.0;
  double first(double x) const { return xx * x; }
  double second(double x, double y) const { return yx * x + yy * y; }
};

/// One image's centre: two rows divided by its noise (columns: the leg's x, y, vx * span, vy * span; tilt,
/// scale), and the residuals. Flashes' errors in time are in the noise.
struct ImageRows {
  std::array<double, 6> row[2];
  double residual[2];
  double time_s = 0.0;  ///< from the leg's origin
  Whitening white;

  /// Adds J^T v: by the fit's unknowns, the gradient of a number that follows both measurements by v.
  void add_gradient(std::size_t leg, const Eigen::Vector2d& v, JointVector& sum) const {
    for (std::size_t k = 0; k < 2; ++k) {
      const double by = v[static_cast<Eigen::Index>(k)];
      for (std::size_t i = 0; i < 4; ++i) sum[kLegStart[leg] + i] += by * row[k][i];
      sum[kTilt] += by * row[k][4];
      sum[kScale] += by * row[k][5];
    }
  }

  /// By how much an acceleration moves the image, divided by its noise. In the observations' axes, times the
  /// scale.
  Eigen::Vector2d moved_by(const Eigen::Vector2d& acceleration_mps2) const {
    const double factor = 0.5 * time_s * time_s;
    const double x = factor * acceleration_mps2.x();
    return {white.first(x), white.yx * x + white.yy * factor * acceleration_mps2.y()};
  }
};
/// `image` is airborne, its leg fitted; `tilt` is the fit's tilt_of().
ImageRows image_rows(const Observations& all, const JointFit& fit, const geometry::Rotation2d& tilt,
                     const Observation& image);

/// From the surface's axes as fitted to those of the observations.
geometry::Rotation2d tilt_of(const JointFit& fit);

/// At the leg's origin of time, in the surface's axes.
Eigen::Vector2d leg_velocity_mps(const JointFit& fit, std::size_t leg);

/// Distance of a surface point from the fitted line. [m]
double surface_residual(const JointFit& fit, const Eigen::Vector2d& point);

/// How that line's height at the point grows with the tilt. [m]
double surface_lever_m(const JointFit& fit, const Eigen::Vector2d& point);

}  // namespace strobe::reduction
