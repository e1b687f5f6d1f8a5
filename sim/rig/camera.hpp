// From the scene of the impact to the photograph: an orthographic side view. Plain values, thread-safe.
#pragma once

#include <cmath>

#include "common/reduction/frame.hpp"
#include "sim/rig/scene.hpp"

namespace strobe::sim {

class Camera {
 public:
  explicit Camera(const Scene& scene);

  /// A point of the scene, in the surface's axes but from the camera's origin on the surface.
  reduction::PointPx project(double x_m, double y_m) const;

  /// Angle on the photograph of a line at `angle_rad` to the surface, counter-clockwise.
  double project_angle(double angle_rad) const;

  /// Whether a ball with its centre there is on the photograph.
  bool sees(double x_m, double y_m) const;

  /// Whether some height there is on the photograph.
  bool may_see(double x_m) const { return std::abs(x_m) <= settings_.half_width_m; }

  double px_per_m() const { return settings_.px_per_m; }
  double half_width_m() const { return settings_.half_width_m; }

 private:
  CameraSettings settings_;
  double turn_rad_;  ///< of the surface line on the photograph
};

}  // namespace strobe::sim
