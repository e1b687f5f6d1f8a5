// How well motions through the contact agree with the images in it: standard errors, and cross-validation. A
// motion is a function of the time fraction, whatever it was computed by: pulse, contact ODE, or fitted
// curve. Thread-safe; making one copies its source and allocates.
#pragma once

#include <functional>
#include <optional>

#include "common/contact/constrained_motion.hpp"
#include "common/contact/spin_pulse.hpp"
#include "common/data/contact_set.hpp"
#include "common/impact/ode/contact_trajectory.hpp"

namespace strobe::contact {

struct TrajectoryPoint {
  double x_m = 0.0;           ///< displacement along the surface since touchdown
  double y_m = 0.0;           ///< height less that at touchdown: <= 0
  double rotation_rad = 0.0;  ///< since touchdown, counter-clockwise
};

/// Takes the time since touchdown over the dwell time: 0…1, and slightly outside of it, as measured images
/// are.
using Trajectory = std::function<TrajectoryPoint(double time_fraction)>;

Trajectory trajectory_of(const impact::SinePulse& pulse);  ///< friction throughout (thesis); rotation 0
Trajectory trajectory_of(const SpinPulse& pulse);
/// Over the ODE's own dwell time; outside of 0…1 the state at the nearer end.
Trajectory trajectory_of(const impact::ContactTrajectory& ode);
Trajectory trajectory_of(const ConstrainedMotion& motion);  ///< a spline that is absent counts as 0

// Standard errors of estimate: how far a computed motion lies from the images in contact,
//   SEE = sqrt(sum (Y - Y')²/(N - 1))
// over the N images between the end points (thesis, Table 17). Along the surface: x fraction · dwell
// distance; normal to it: y fraction · diameter. Pure; thread-safe; allocates.

/// Turns a set's fractions into metres and radians.
struct FractionScale {
  double dwell_distance_m = 0.0;  ///< > 0, along the surface
  double diameter_m = ball::kThesisDiameter_m;
  /// Rotation from touchdown to lift-off, counter-clockwise, if known: the thesis prints only fractions of
  /// it.
  std::optional<double> total_rotation_rad;
};

/// For one choice of the total rotation that the rotation fractions refer to.
struct RotationError {
  double total_rad = 0.0;
  double see_rad = 0.0;
  std::optional<double> see_fraction;  ///< see_rad/|total_rad|; absent for a total of 0
};

struct RotationErrors {
  /// The total is the trajectory's own, so that shapes are compared. Where that total is near zero (backspin)
  /// the measured angles shrink with it: judge those sets by the other two.
  RotationError own_total;
  /// The total that fits best, sum(q·phi)/sum(q²) over the images between the end points, with its sd.
  RotationError fitted_total;
  std::optional<double> fitted_total_sd_rad;  ///< absent where the images scatter by rounding alone
  /// Fraction of the trajectory's squared rotation (about the touchdown's angle) that the images follow, 0…1.
  double r_squared = 0.0;
  std::optional<RotationError> given_total;  ///< with FractionScale::total_rotation_rad
  int n = 0;                                 ///< images between the end points that have a rotation
};

struct StandardErrors {
  double see_x_m = 0.0;
  double see_y_m = 0.0;
  int n = 0;                               ///< images between the end points
  std::optional<RotationErrors> rotation;  ///< absent with fewer than two rotations, or all of them zero
};

/// Fails on fewer than two images between the end points, on a scale out of range, and on a trajectory that
/// is not finite at an image.
Result<StandardErrors> standard_errors(const data::ContactSet& set, const Trajectory& trajectory,
                                       const FractionScale& scale);

/// The thesis's comparison: the damped sine pulse with friction throughout, without spin.
struct ContactInputs {
  double vx_td_mps = 0.0;
  double vy_td_mps = 0.0;  ///< < 0
  double e = 0.0;          ///< see impact::damping_from_restitution
  double mu = 0.0;         ///< impulse ratio; negative where the surface drove the ball forward
  double dwell_time_s = 0.0;
  double dwell_distance_m = 0.0;  ///< > 0, along the surface
  double diameter_m = ball::kThesisDiameter_m;
  impact::PulseForm form = impact::PulseForm::exact;
};

/// Fails like standard_errors(), and on inputs out of range. An image after lift-off (time fraction above 1)
/// is compared with the formula continued beyond it.
Result<StandardErrors> pulse_standard_errors(const data::ContactSet& set, const ContactInputs& inputs);

// Leave-one-out cross-validation of the approaches to the contact: how well cubics, splines and the pulse
// predict an image that they were not fitted to. Pure; thread-safe; allocates.

/// Root mean square error of the prediction of each image by a fit without that image; nullopt where too few
/// images are left for a fit. The spline's weight is chosen for each; the cubic is fitted with the end
/// points; the pulse is not fitted to images at all.
struct LeaveOneOutRms {
  std::optional<double> cubic, spline, pulse;
};

struct CrossValidation {
  LeaveOneOutRms x_m, y_m, rotation_rad;
  int n = 0;
};

/// Over the images between the end points within 0…1; rotations with the scale's total. Errors as
/// fit_constrained_motion().
Result<CrossValidation> leave_one_out(const data::ContactSet& set, const ContactScale& scale,
                                      const EndVelocities& ends, const Trajectory& pulse,
                                      bool no_force = true, const SplineOptions& options = {});

}  // namespace strobe::contact
