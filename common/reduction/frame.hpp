// A digitized photograph with the time of each image: what the reduction starts from.
// Axes of the photograph: x right, y up, in pixels (or tablet units). Plain values, thread-safe.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace strobe::reduction {

enum class Leg { incoming, contact, rebound };

/// A point of the photograph. [px]
struct PointPx {
  double x = 0.0;
  double y = 0.0;
};

/// One image of the ball.
struct BallImage {
  double time_s = 0.0;     ///< middle of the flash, any origin common to the frame
  std::optional<Leg> leg;  ///< absent: found by the reduction
  PointPx centre_px;
  double diameter_px = 0.0;           ///< > 0
  std::optional<double> equator_rad;  ///< counter-clockwise from +x, modulo pi; absent: not seen
  std::optional<double> time_sd_s;
  std::optional<int> flash_index;
  std::optional<std::array<double, 4>> centre_cov_px2;  ///< row-major 2x2; overrides Frame::centre_sd_px
  std::optional<double> diameter_sd_px;                 ///< overrides Frame::diameter_sd_px
  std::optional<double> equator_sd_rad;                 ///< overrides Frame::equator_sd_rad
  std::optional<PointPx> top_px;                        ///< top of the ball, contact images
  std::optional<double> contact_width_px;
  std::string source;  ///< "auto", "hand" or empty
};

/// The session's record: free key-value notes (frame number, ball, surface, operator, remarks ...).
using Record = std::map<std::string, std::string>;

/// A digitized photograph. Images are in order of time. What is absent was not known.
struct Frame {
  int shot_id = 0;
  double ball_diameter_m = 0.0;              ///< 0.01 to 1
  std::optional<double> ball_diameter_sd_m;  ///< the diameter's tolerance as a standard deviation
  std::vector<PointPx> surface_px;           ///< at least 2 points of the surface line
  std::optional<double> surface_sd_px;       ///< of each coordinate; absent: as centre_sd_px
  std::optional<double> centre_sd_px;        ///< of each coordinate
  std::optional<double> diameter_sd_px;
  std::optional<double> equator_sd_rad;
  std::optional<double> px_per_m;  ///< calibrated scale; absent: from the ball's diameter
  std::optional<double> px_per_m_sd;
  double surface_angle_deg = 0.0;  ///< inclination of the plate against the horizontal, from an inclinometer
  std::optional<double> temperature_c;
  Record record;
  std::vector<BallImage> images;
};

}  // namespace strobe::reduction
