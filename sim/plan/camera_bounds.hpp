// How lens and pixels displace what is measured of a ball and of the surface. Thread-safe; no allocation.
//
// perspective, lens_distortion. Where a ball is seen, how large and at which angle is known in closed form
// (sim/rig/camera.hpp): `by` is the difference between the scene's camera and one without the effect, for a
// ball at that place. To first order, p being the place from the axis, L the distance, z the way off the
// plane, k the distortion, r0 half the view's diagonal:
//   perspective      place by p·(z/L + R²/L²), diameter by D·(z/L + p²/(4L²) + R²/(2L²)), the equator by up
//                    to p²/(2L²);
//   lens_distortion  place by p·k·p²/r0² (and 3k·R²/r0²), diameter by D·2k·p²/r0², the equator by up to
//                    k·p²/r0².
// `within` is what the one changes of the other, which is left out or not: at most the product of their
// shares, s_p = |z|/(L - |z|) + (p² + R²)/(L - |z|)² and s_d = 3|k|·(p² + R²)/r0², times the lengths p, D and
// a radian, doubled for the terms beyond the second order (shares are below a quarter wherever a scene is
// valid). The equator's angle is drawn evenly from all, so that nothing is known of the sign of what turns
// it: `within` has all of it, p²/(2·(L - |z|)²)·(1 + p²/(L - |z|)²) + R·p/(L - |z|)² and s/(1 - 2s), s =
// |k|·p²/r0², the largest over all angles of a line seen at that place.
//
// pixels (sim/rig/pixels.hpp says what is drawn and measured). With half diameter r in pixels: a pixel that
// the outline crosses, at most 8r + 8 of them, is rounded by at most 1/(2·220) of the ball's brightness;
// where the outline lies flat, 4·sqrt(2r) pixels at its top and bottom, cutting rows into 8 lines errs by at
// most 1/16. All errors adding up, over the area pi·r²:
//   centre    (r + 1)·((8r + 8)/440 + 4·sqrt(2r)/16)/(pi·r²) px,
//   diameter  ((8r + 8)/440 + 4·sqrt(2r)/16)/(pi·r) px.
// The equator is the main axis of a bar of half length 0.6r and half width 0.06r, whose moments differ by
// 0.0171·r⁴: its outline, at most 5.3r + 8 pixels, is rounded by 1/320, and 2.4r of them, where it may lie
// flat, err by 1/16, at arms of 0.6r and 0.06r + 1:
//   equator   (0.6r)(0.06r + 1)((5.3r + 8)/320 + 2.4r/16)/(0.0171·r⁴) rad;
// and a ball that moves by s px during the flash has s²/12 added to the moment along its way, which turns the
// axis by up to s²/12/(2·0.119·r²) (in proportion to 1/(1 - s²/12/(0.119·r²))). Below 12 px no equator is
// seen: no bound. Below 4 and beyond 4000 px nothing is drawn.
#pragma once

#include "sim/motion/ball_path.hpp"
#include "sim/plan/displacement.hpp"
#include "sim/rig/camera.hpp"
#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

class CameraBounds {
 public:
  explicit CameraBounds(const Scene& scene);

  /// Of the image of a ball, x_m from the camera's origin; for perspective, lens_distortion and pixels
  /// (the smear apart), zero for other effects.
  BoundedDisplacement of_ball(Effect effect, double x_m, double y_m, double off_plane_m,
                              double equator_rad) const;

  /// Of a point of the surface that the effect moves so far on the photograph. [px]
  BoundedDisplacement of_surface(Effect effect, double x_m, double dx_px, double dy_px) const;

  /// Rotation of the measured equator by motion blur, for a ball of that speed. [rad]
  double motion_blur_rad(double speed_mps) const;

 private:
  const Camera* without(Effect effect) const;
  double product_of_shares(double x_m, double y_m, double off_plane_m) const;
  double rotation_rad(Effect effect, double x_m, double y_m, double off_plane_m) const;
  Displacement on_object(double dx_px, double dy_px) const;
  BoundedDisplacement of_pixels(double diameter_px) const;

  Scene scene_;
  Camera full_;
  Camera without_perspective_;
  Camera without_distortion_;
  double turn_cos_;
  double turn_sin_;
  double side_;
};

}  // namespace strobe::sim
