// The automatic digitizer: a photograph in, a frame out, with a covariance for every centre, diameter and
// angle, never a guess for what cannot be measured. Deterministic for any number of threads; no I/O;
// thread-safe.
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
#include "host/digitize/surface/surface_line.hpp"

namespace strobe::digitize {

struct DigitizeSettings {
  double ball_diameter_m = 0.0651;
  std::optional<double> ball_diameter_sd_m;
  double px_per_m = 0.0;              ///< in the ball's plane, > 0: a start, refined from the balls
  std::optional<double> px_per_m_sd;  ///< present: calibrated, and handed on with the frame
  /// How far the ball's size on the photograph may be from px_per_m·ball_diameter_m, as a share.
  double size_tolerance = 0.08;
  PlaneMap map = PlaneMap::plain(0);
  std::optional<SurfaceLine> surface;  ///< of the calibration; absent: found from the plate
  /// Present: flight to the right (false) or to the left (true) is known; absent: the bounce tells.
  std::optional<bool> leftwards;
  std::optional<std::vector<double>> flash_times_s;  ///< of all flashes, ascending; images then get theirs
  Effort effort = Effort::standard;
};

/// A candidate that became no image, or an image's part that was not measured.
struct Unmeasured {
  cv::Point2d centre;  ///< plane px
  double diameter = 0.0;
  std::string what;  ///< "image", "equator", "diameter" ...
  Rejection why;
};

struct Digitization {
  reduction::Frame frame;         ///< images in order of time; sources "auto"
  std::vector<Outline> outlines;  ///< one an image, in the frame's order
  std::vector<Unmeasured> unmeasured;
  std::optional<Rejection> no_surface;                   ///< why there is no surface line
  std::vector<std::string> remarks;                      ///< for a person: what may be doubted
  std::vector<std::pair<std::string, double>> stage_ms;  ///< time spent, by stage
};

/// Fails with one line for settings out of range. A photograph without a ball is a result: no images, and
/// reasons.
Result<Digitization> digitize(const Photograph& photograph, const DigitizeSettings& settings);

}  // namespace strobe::digitize
