// Where the lens is in front of a board: from the homographies, whose columns are at right angles and of
// equal length for the right focal length alone (Zhang 2000), and from a tape. Deterministic; thread-safe.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "host/camera/board_fit.hpp"

namespace strobe::camera {

/// In front of the first view's board.
struct LensPose {
  double focal = 0.0;  ///< in units of fit.lens.focal_px
  cv::Point2d foot_m;  ///< of the perpendicular from the lens to the board, on the board
  double distance_m = 0.0;
  double distance_sd_m = 0.0;
  double tilt_rad = 0.0;  ///< of the optical axis against the board's normal
};

/// Absent if photographs and tape leave the distance uncertain by more than a quarter.
std::optional<LensPose> locate_lens(const BoardFit& fit, std::optional<double> distance_m,
                                    double distance_sd_m);

}  // namespace strobe::camera
