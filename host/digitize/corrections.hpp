// Manual corrections of a digitized photograph: images added, moved and removed, the surface's line given.
// Images measured by hand are marked (BallImage::source "hand"), and so is the line
// (Digitization::surface_by_hand); all others stay as they were measured. Deterministic; no I/O; thread-safe;
// allocates.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::digitize {

/// Default standard deviations of manual measurements, as found for digitizing with a transparent overlay on
/// a tablet.
inline constexpr double kManualCentre_sd_m = 0.0005;
inline constexpr double kManualEquator_sd_rad = 0.0174532925199433;  // 1 degree

/// A point of the frame (x right, y up) or of the photograph (column, row from the top).
struct ManualPoint {
  cv::Point2d point;
  bool in_image = false;
};

/// What was measured of one image; absent: not measured.
struct ManualMeasurement {
  std::optional<ManualPoint> centre;
  std::optional<double> centre_sd_px;
  std::optional<double> diameter_px;
  bool diameter_in_image = false;  ///< diameter_px is the photograph's at the centre, not the frame's
  std::optional<double> diameter_sd_px;
  std::optional<double> equator_rad;
  bool equator_in_image = false;  ///< counter-clockwise as the photograph shows it, not the frame
  std::optional<double> equator_sd_rad;
  bool no_equator = false;  ///< the line that was found is wrong
  std::optional<reduction::Leg> leg;
  std::optional<ManualPoint> top;
  std::optional<double> contact_width_px;
  std::optional<double> time_s;  ///< used if the flashes' times are not known
};

/// Two points of the surface's line.
struct ManualSurface {
  ManualPoint left, right;
  std::optional<double> sd_px;  ///< of each coordinate
};

struct Correction {
  enum class Kind { add, move, remove, surface };
  Kind kind = Kind::add;
  ManualPoint at;  ///< move, remove: selects the image with the nearest centre, within half a diameter
  ManualMeasurement measured;
  ManualSurface surface;
  std::string location;  ///< "FILE:LINE", for messages
};

/// Reads a file of corrections (TOML):
///
///   [[remove]]
///   at_px = [812, 640]            # the image nearest to this point of the frame (x right, y up) ...
///   [[move]]
///   at_image_px = [1200, 615]     # ... or of the photograph (column, row from the top)
///   centre_px = [1203.5, 1224.0]  # or centre_image_px; what is left out stays as it was
///   equator_deg = 31
///   [[add]]
///   centre_px = [1410, 1180]
///   diameter_px = 261             # left out: the other images' median
///   leg = "rebound"               # left out: found
///   [surface]                     # the line in place of the one that was found
///   left_px = [100, 210]          # or left_image_px
///   right_px = [2300, 214]        # or right_image_px
///   sd_px = 1                     # left out: as a point by hand
///
/// Further keys of move and add: centre_sd_px, diameter_sd_px, equator_sd_deg, no_equator, top_px,
/// top_image_px, contact_width_px, time_s; diameter_image_px and equator_image_deg are those on the
/// photograph, from which a tilted camera's frame differs. Fails with "FILE:LINE: table.key: what is wrong".
Result<std::vector<Correction>> parse_corrections(std::string_view text, const std::string& file_name);

/// Applies all at once: `at` refers to the images as they were found. Order, legs and times are then found
/// again, and removed images are listed among the unmeasured with Reason::by_hand. With a surface line the
/// legs that no one gave by hand are found anew, and the images in contact are measured against it. Fails
/// with "FILE:LINE: what is wrong" if no image is near, two corrections select the same image, an added image
/// has no diameter to take, or there is neither a scale nor an image; the digitization is then unchanged.
Result<void> apply_corrections(Digitization& digitization, const std::vector<Correction>& corrections,
                               const DigitizeSettings& settings);

}  // namespace strobe::digitize
