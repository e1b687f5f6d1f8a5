// Spin vector of a flight from the planes of the line drawn around the ball, one for each image. The normal n
// of that plane stands still in the ball and so goes round the spin's axis on a cone,
//   n(t) = exp([omega s]x) n(0),   s = (1 - exp(-decay t)) / decay,
// whatever its angle to the axis: a line need be no great circle, nor square to the axis. What the normals do
// not show is a turn about themselves: a line whose plane stands square on the spin's axis does not move.
//
// Weighted least squares in two rotations of the normal and three numbers of omega (Gauss-Newton on the
// rotation group, with the left Jacobian of SO(3): Barfoot, State Estimation for Robotics, 7.1.5), each plane
// with the sign that is nearer. Starts: the cones through three images each, with every sign of their normals
// and every number of turns between them that a spin may make.
// Camera axes as in line_normal.hpp. Deterministic; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/attitude/line_normal.hpp"

namespace strobe::attitude {

/// Spins faster than that are not looked for.
struct SpinLimits {
  double fastest_radps = 0.0;  ///< > 0, finite
  double decay_per_s = 0.0;    ///< domega/dt over -omega, >= 0
};

struct LineSpin {
  Eigen::Vector3d omega_radps = Eigen::Vector3d::Zero();  ///< at time_s
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();   ///< of omega [rad^2/s^2]
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();       ///< of the line's plane at time_s
  double time_s = 0.0;                                    ///< mean of the readings'
  double decay_per_s = 0.0;
  /// By how much chi squared grows where the spin is about the camera's axis: chi squared of two degrees of
  /// freedom if it truly is. Below kRejectedOfTwo the spin above is that one's, corrected to the first order.
  double planar_excess = 0.0;
  double chi_squared = 0.0;           ///< of the readings in use; degrees of freedom: two each, less five
  std::vector<std::size_t> left_out;  ///< readings that do not fit the others; at most one
  /// Other spins that explain the readings as well (kComparable), up to the fastest.
  std::vector<Eigen::Vector3d> alternatives_radps;

  /// The normal at another time.
  Eigen::Vector3d normal_at(double time) const;
  /// Seconds that a spin without decay would need from time_s for the same turn.
  double stretched_s(double time) const;
};

/// Chi squared of two degrees of freedom that chance passes once in ten thousand.
inline constexpr double kRejectedOfTwo = 18.42;
/// Chi squared that differs by less than 3 sd tells no spin from another.
inline constexpr double kComparable = 9.0;

/// The slowest of all spins that explain the readings as well as any. Returns nullopt for fewer than three
/// readings, and where no steady spin explains them (by chi squared, once in ten thousand by chance)
/// whichever one is left out; of three or four none is. `guesses_radps`: spins to start from, too. Readings
/// are in order of time, at most 512; times differ.
std::optional<LineSpin> fit_line_spin(std::span<const LineReading> readings, const SpinLimits& limits,
                                      std::span<const Eigen::Vector3d> guesses_radps = {});

/// Whether tilts say that the ball does not spin about the camera's axis.
struct PlanarTest {
  /// By how much chi squared of the tilts falls where the axis may be tilted: of two degrees of freedom if it
  /// is not.
  double chi_squared_gain = 0.0;
  double chi_squared = 0.0;  ///< what is left of it, with so many degrees of freedom
  double degrees_of_freedom = 0.0;
  /// Spin across the camera's axis over that along it (x, y), to the first order, and its covariance.
  Eigen::Vector2d ratio = Eigen::Vector2d::Zero();
  Eigen::Matrix2d ratio_covariance = Eigen::Matrix2d::Zero();
};

/// Of readings whose angles follow a spin about the camera's axis on and on, half turns included (each
/// reading is its plane's with the angle that continues the others'): the tilt then stays, and with a spin
/// across of omega_z·(rx, ry) it follows, to the first order, tilt + const = -rx·sin(angle) + ry·cos(angle).
/// Returns nullopt for fewer than three readings, or where the line turned too little to tell. No allocation.
std::optional<PlanarTest> test_planar(std::span<const LineReading> readings);

}  // namespace strobe::attitude
