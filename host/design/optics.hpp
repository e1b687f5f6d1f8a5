// What a lens at a distance does: scale, view, sharpness, perspective. A thin lens, focused on the balls'
// plane, distances from its principal plane (E. Hecht, Optics, 5th ed., sections 5.2 and 5.3). Pure;
// thread-safe.
#pragma once

#include <optional>

#include "common/result.hpp"

namespace strobe::host {

struct LensSetUp {
  int width_px = 0, height_px = 0;  ///< of the sensor, 16 to 100,000
  double pixel_pitch_um = 0.0;      ///< 0.1 to 100
  double focal_length_mm = 0.0;     ///< 0.1 to 10,000
  double f_number = 0.0;            ///< as engraved, for far away; 0.5 to 128
  double distance_m = 0.0;  ///< lens to plane, beyond the focal length; infinite where not said otherwise
};

/// Fails with the name of a field that is out of range, and the range.
Result<void> check(const LensSetUp& set_up);

// What follows wants a set-up that check() accepts.

/// f/(d - f): of Newton's form of the lens equation. 0 for an infinite distance.
double magnification(const LensSetUp& set_up);
/// Of the plane on the photograph: the magnification over the pitch.
double px_per_m(const LensSetUp& set_up);

struct ViewSize {
  double width_m = 0.0, height_m = 0.0;  ///< infinite for an infinite distance
};
ViewSize view_size(const LensSetUp& set_up);

struct DepthOfField {
  double near_m = 0.0;
  double far_m = 0.0;  ///< may be infinite
};
/// Between which distances from the lens a point is imaged as a disc of at most this diameter, above 0:
/// d f²/(f² ± N c (d - f)), exact for a thin lens (S. F. Ray, Applied Photographic Optics, 3rd ed., ch. 22).
DepthOfField depth_of_field(const LensSetUp& set_up, double circle_px);

/// Sd of the blur along a line of what is off the plane, positive: farther away, above -distance: a uniform
/// disc's, a quarter of its diameter f/N m |z|/(d + z). Distance finite.
double defocus_sd_px(const LensSetUp& set_up, double off_plane_m);

/// Sd along a line of the Airy disc, as the Gaussian of the same curvature at its middle: √2 λ N (1 + m)/π
/// (B. Zhang, J. Zerubia, J.-C. Olivo-Marin, Applied Optics 46, 1819, 2007, paraxial). Its wings are wider.
double diffraction_sd_px(const LensSetUp& set_up, double wavelength_nm = 550.0);

/// By how much smaller, as a share, all looks that is a millimetre farther than the plane: 1/d, by similar
/// triangles at the lens' middle.
double perspective_per_mm(const LensSetUp& set_up);

/// How far the image of what moves in the plane goes during a flash. As a blur's sd, for a flash of even
/// light: divided by √12. Speed and duration at least 0.
double motion_px(const LensSetUp& set_up, double speed_mps, double flash_s);

/// The distance at which this sensor and focal length have the scale, above 0: f (1 + 1/m).
double distance_for_scale_m(const LensSetUp& set_up, double wanted_px_per_m);

/// The longest of usual lenses, 4 to 300 mm, that sees as much at the set-up's distance, finite. Returns
/// nullopt if none does.
std::optional<double> focal_length_for_view_mm(LensSetUp set_up, const ViewSize& wanted);

}  // namespace strobe::host
