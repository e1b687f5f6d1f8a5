// Leave-one-out cross-validation of the approaches to the contact: how well cubics, splines and the pulse
// predict an image that they were not fitted to. Pure; thread-safe; allocates.
#pragma once

#include <optional>

#include "common/contact/trajectory.hpp"

namespace strobe::contact {

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
