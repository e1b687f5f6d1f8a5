// Bounces in three dimensions, by the closed forms of the plane: velocity and spin are vectors.
//
// Axes of the surface, right-handed: x and z along it, y up from it; the ball comes from above (vy < 0). With
// v = (vx, vz) and w = R·(omega_z, -omega_x) the contact point slips by s = v + w, friction F on the surface
// changes m·v by -F and alpha·m·w by -F, and omega_y stays as it was: the plane's equations, of vectors along
// the surface. Pivoting friction about y is left out: its couple is of the order of mu·N·a, a the footprint's
// radius.
//
// Without an offset the bounce splits: isotropic friction acts along s, whose direction stays, so that in
// axes turned to it the bounce is the plane's, and what is across s stays. An offset acts along the rolling
// velocity (v - w)/2, which where it is not parallel to s turns the slip during the contact. Then the
// closed form is an approximation, as the offset itself: of the impulses alone. Friction's is what gripping
// requires, for the slip and the offset's couple together, or, if that is more than mu·J, mu·J in that
// direction. The contact's mechanics (spatial_contact.hpp) follow the slip as it turns.
// Sources: A. Domenech, Eur. J. Phys. 26 (2005); R. Cross, Am. J. Phys. 70 (2002).
// Pure functions, no allocation: thread-safe, real-time safe.
#pragma once

#include <Eigen/Core>
#include <array>
#include <tl/expected.hpp>

#include "common/impact/closed_form/rebound.hpp"

namespace strobe::impact {

struct SpatialMotion {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_radps = Eigen::Vector3d::Zero();
};

/// Along the surface, (x, z): of a velocity; of a spin what rolls along it, w/R; of the contact point.
Eigen::Vector2d along_surface(const Eigen::Vector3d& velocity);
Eigen::Vector2d rolling_spin(const Eigen::Vector3d& spin);
Eigen::Vector2d slip_mps(const ball::Ball& ball, const SpatialMotion& motion);

/// The motion with another vy and with changes of v and of w/R.
SpatialMotion changed(const SpatialMotion& motion, double vy_mps, const Eigen::Vector2d& dv_mps,
                      const Eigen::Vector2d& dspin_radps);

/// Its motions along x, along z and about y as the plane's, which are within the ranges where it is.
std::array<Motion, 3> planar_parts(const SpatialMotion& motion);

struct SpatialRebound {
  SpatialMotion lift_off;
  Regime regime = Regime::slides;  ///< whether friction was at its limit throughout
  Eigen::Vector2d slip_lo_mps = Eigen::Vector2d::Zero();
  double impulse_ratio = 0.0;                          ///< of friction's impulse to the normal one, >= 0
  Eigen::Vector2d offset_m = Eigen::Vector2d::Zero();  ///< of the normal force that acted
};

/// As regime_of() in the plane.
Regime regime_of(const ball::Ball& ball, const SpatialMotion& touchdown, const SpatialRebound& rebound);

/// As in the plane, to whose results they are equal to rounding where vz, omega_x and omega_y are 0. Errors:
/// those of rigid() and grip() of the plane.
tl::expected<SpatialRebound, InputError> rigid(const ball::Ball& ball, const SpatialMotion& touchdown,
                                               double e, double mu);
tl::expected<SpatialRebound, InputError> grip(const ball::Ball& ball, const SpatialMotion& touchdown,
                                              const Coefficients& coefficients);

}  // namespace strobe::impact
