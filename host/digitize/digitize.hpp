// The automatic digitizer: from a photograph to a frame, with a covariance for every centre and an sd for
// every diameter and angle. What cannot be measured is left out, never guessed. Deterministic for any number
// of threads; no I/O; thread-safe; allocates.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/path/path.hpp"
#include "host/digitize/surface/surface_line.hpp"
#include "host/digitize/transfer/transfer_curve.hpp"

namespace strobe::digitize {

struct DigitizeSettings : FlightFacts {
  std::optional<double> ball_diameter_sd_m;
  std::optional<double> fastest_spin_radps;  ///< copied to the frame
  std::optional<double>
      px_per_m;  ///< in the balls' plane, > 0; a first guess unless calibrated; absent: found
  std::optional<double> px_per_m_sd;  ///< present: px_per_m is calibrated, and copied to the frame
  /// Largest relative difference of the ball's diameter from px_per_m·ball_diameter_m, and of single images'
  /// from the one that they agree on, above 0 and below 0.9. At least .12 where the scale is found.
  double size_tolerance = 0.08;
  PlaneMap map = PlaneMap::uncalibrated(0);
  std::optional<SurfaceLine> surface;  ///< calibrated; absent: found from the plate
  Effort effort = Effort::standard;
  /// Whether a line is drawn around the ball's equator. Without one none is looked for: seams, panels and
  /// print tell no spin. Nor is one on balls of fewer than 30 image px, which are measured at twice the size.
  bool line_drawn = true;
};

/// The ball's size by its images.
struct BallScale {
  double diameter_px = 0.0, diameter_sd_px = 0.0;  ///< plane px
  double px_per_m = 0.0;
  double px_per_m_sd = 0.0;  ///< with the ball's tolerance where known
  int images = 0;
};

struct Digitization {
  reduction::Frame frame;         ///< images in order of time; sources "auto"
  std::vector<Outline> outlines;  ///< one for each image, in their order
  std::vector<Unmeasured> unmeasured;
  std::optional<Rejection> no_surface;    ///< why there is no surface line
  bool surface_by_hand = false;           ///< a person gave it
  std::optional<BallScale> scale;         ///< absent without images
  std::optional<TransferCurve> transfer;  ///< of numbers to light; absent: the photograph cannot tell
  std::vector<std::string> remarks;       ///< assumptions and ambiguities, for the operator
  std::vector<std::pair<std::string, double>> stage_ms;  ///< wall time of each stage
};

/// Fails with one line for settings out of range. A photograph without a ball gives no images, but reasons.
/// So does one whose balls have clearly not the size that is given: a remark says which they have.
Result<Digitization> digitize(const Photograph& photograph, const DigitizeSettings& settings);

/// Tops and flat widths of the images in contact, by the frame's surface line, of those that have none; what
/// cannot be measured is listed. Nothing without a line.
void measure_contacts(Digitization& digitization);

}  // namespace strobe::digitize
