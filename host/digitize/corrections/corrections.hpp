// What a person overrules in a digitized photograph: images added, moved and removed. What a person measured
// is marked as such (BallImage::source "hand"); what the corrections leave alone stays as it was measured.
// Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/digitize/digitize.hpp"

namespace strobe::digitize {

/// What a hand's measurements are worth where the person does not say: what digitizing with a transparent
/// overlay on a tablet was found to leave.
inline constexpr double kManualCentre_sd_m = 0.0005;
inline constexpr double kManualEquator_sd_rad = 0.0174532925199433;  // 1 degree

/// A point as the person wrote it: of the frame (x right, y up) or of the photograph (column, row from the
/// top).
struct ManualPoint {
  cv::Point2d point;
  bool of_photograph = false;
};

/// What was measured by hand of one image. What is absent was not.
struct ManualMeasurement {
  std::optional<ManualPoint> centre;
  std::optional<double> centre_sd_px;
  std::optional<double> diameter_px;
  std::optional<double> diameter_sd_px;
  std::optional<double> equator_rad;
  std::optional<double> equator_sd_rad;
  bool no_equator = false;  ///< what was taken for the line is none
  std::optional<reduction::Leg> leg;
  std::optional<ManualPoint> top;
  std::optional<double> contact_width_px;
  std::optional<double> time_s;  ///< only where the flashes' times are not known
};

struct Correction {
  enum class Kind { add, move, remove };
  Kind kind = Kind::add;
  ManualPoint at;  ///< move, remove: the image whose centre is nearest, at most half a diameter away
  ManualMeasurement measured;
  std::string place;  ///< "FILE:LINE", for messages
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
///
/// Further keys of move and add: centre_sd_px, diameter_sd_px, equator_sd_deg, no_equator, top_px,
/// top_image_px, contact_width_px, time_s. Fails with "FILE:LINE: table.key: what is wrong".
Result<std::vector<Correction>> parse_corrections(std::string_view text, const std::string& file_name);

/// Applies them all at once to what was digitized: "at" means the images as they were found. The images are
/// then ordered and given legs and times anew; outlines stay one an image, and what was removed is listed
/// among the unmeasured, by_hand. Fails with "FILE:LINE: what" where no image is near, where two corrections
/// mean the same image, or where an added image has no diameter to take; the digitization is then unchanged.
Result<void> apply_corrections(Digitization& digitization, const std::vector<Correction>& corrections,
                               const DigitizeSettings& settings);

}  // namespace strobe::digitize
