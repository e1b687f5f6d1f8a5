// Free flight of the simulated ball: gravity, drag, lift (Magnus) and decay of the spin, integrated in small
// steps. Readouts are compared with it, so it is written from the equation of motion alone and shares
// no code with common/flight or the reduction. Axes of the surface: x along it in the direction
// of travel, y up from it; spin counter-clockwise (backspin) positive. Plain values: thread-safe, no
// allocation.
//
//   dv/dt = g - q·C_D·|v|·v + q·C_L·|v|·(z × v),   q = density·pi·R²/(2·mass)
//   C_L = R·omega/(b·R·|omega| + a·|v|) with the spin's sign, backspin lifts; a = 1, b = 2: tennis balls
//   domega/dt = -c·|v|·omega,   c = spin_decay_per_m
//
// A spin that is not across the plane of flight lifts by its part across v, along omega × v:
//   dv/dt = g - q·C_D·|v|·v + q·|v|·R·(omega × v)/(b·R·|omega × v|/|v| + a·|v|)
// and decays as a whole, so that its direction stays: the ball turns about one axis.
//
// C_D .51 to .65 and this C_L: measured on tennis balls by Stepanek (1988) and others. Each effect that the
// model leaves out has its term left out; without air (or with every effect of it left out) the flight is the
// parabola in closed form.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

/// Of the centre, and the spin. [m, m/s]
struct FlightState {
  double x_m = 0.0;
  double y_m = 0.0;
  double vx_mps = 0.0;
  double vy_mps = 0.0;
  double omega_radps = 0.0;   ///< about the flight's axis
  double rotation_rad = 0.0;  ///< since the start, likewise; counter-clockwise
  double z_m = 0.0;           ///< towards the camera
  double vz_mps = 0.0;
};

class Flight {
 public:
  /// Flight of the scene's ball in its air, over its inclined plate. The start's spin is omega_radps.
  Flight(const Scene& scene, const FlightState& start, double omega_radps,
         const Model& model = Model::full());
  /// With the spin as a vector; the start's vz_mps counts.
  Flight(const Scene& scene, const FlightState& start, const Eigen::Vector3d& spin_radps, const Model& model);

  /// What the ball spins about, of length 1; z unless the spin was given as a vector.
  const Eigen::Vector3d& axis() const { return axis_; }

  /// The state `time_s` after the start (negative: before it). Error below 1e-12 of the distance flown for
  /// tennis balls in usual air; it grows with the fifth power of q·|v| and of c·|v|.
  FlightState at(double time_s) const;

  /// What at() gives for each, to the last bit; instants near each other are integrated side by side, in
  /// hardly more time than one.
  using Instants = std::array<double, 4>;
  std::array<FlightState, 4> at(const Instants& time_s) const;

  /// Within a centimetre for any ball in any air after the start, at a fifth of at()'s cost.
  FlightState roughly_at(double time_s) const;

  /// When it is at the height of its start again, which it leaves upwards. Returns nullopt if not within two
  /// seconds.
  std::optional<double> time_back_down_s() const;

  /// When, going back from the start, the centre was at `x_m`. Returns nullopt if it was not within a minute.
  /// The ball must move along +x at the start, with x_m behind it.
  std::optional<double> time_back_at_x_s(double x_m) const;

 private:
  struct Law {
    double radius_m = 0.0;
    double drag_pm = 0.0;   ///< q·C_D, per metre
    double lift_pm = 0.0;   ///< q, or 0 without lift
    double decay_pm = 0.0;  ///< of the spin
    double lift_offset = 1.0, lift_slope = 2.0;
    double gravity_x_mps2 = 0.0;
    double gravity_y_mps2 = 0.0;
  };

  FlightState at(double time_s, double steps) const;
  FlightState fall(double time_s) const;
  FlightState step(const FlightState& s, double h_s) const;
  FlightState spatial_step(const FlightState& s, double h_s) const;

  FlightState start_;
  Law law_;
  bool parabola_;
  bool spatial_ = false;
  Eigen::Vector3d axis_ = Eigen::Vector3d::UnitZ();
};

/// A ball that falls from rest through height_m > 0 in the scene's air, or rises through it to rest: its
/// speed at the lower end, and how long it takes. Without spin; the plate's inclination is left out.
struct VerticalFlight {
  double speed_mps = 0.0;
  double time_s = 0.0;
};
VerticalFlight falling(const Scene& scene, double height_m);
VerticalFlight rising(const Scene& scene, double height_m);

}  // namespace strobe::sim
