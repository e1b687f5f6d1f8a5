// What the board's points leave open of the map from the photograph to the plane: the parameters' covariance as a few
// independent errors of the whole map. Deterministic; thread-safe; allocates; no I/O.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <vector>

#include "host/camera/board_fit.hpp"

namespace strobe::camera {

/// How the map changes by one standard deviation of one error. Added to Calibration::rectify and the lens' terms.
struct MapError {
  cv::Matx33d rectify;                 ///< (2, 2) = 0
  std::array<double, 4> lens_terms{};  ///< k1, k2, p1, p2
};

/// undistorted image px to plane px, (2, 2) = 1, of the first view; `to_plane` is from board metres to plane px.
cv::Matx33d rectification(const cv::Matx33d& homography, const digitize::LensDistortion& lens,
                          const cv::Matx33d& to_plane);

/// The largest first; those that move no point of the photograph by 0.002 px, a tenth of a centre's noise at its best,
/// are left out. Errors that turn or shift the plane as a whole are among them: surface and balls move alike.
std::vector<MapError> map_errors(const BoardFit& fit, const cv::Matx33d& to_plane, int width_px,
                                 int height_px);

}  // namespace strobe::camera
