// From the boards' points to lens and homographies, by least squares: each photograph's board is mapped by a
// homography of its own to the ideal photograph, which one lens then distorts. Nothing need be known of the
// focal length, so that a single photograph will do. Deterministic; thread-safe; allocates.
#pragma once

#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "host/camera/board.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::camera {

struct BoardFit {
  /// Unit of the normalized photograph: (image px - lens.centre_px)/lens.focal_px.
  digitize::LensDistortion lens;
  int lens_terms = 0;                     ///< 0; 1: k1; 2: k1, k2; 4: k1, k2, p1, p2
  std::vector<cv::Matx33d> homographies;  ///< board [m] to normalized ideal photograph, (2, 2) = 1
  /// Of all parameters: 8 for each homography (row by row, without the last), then k1, k2, p1, p2 as far as
  /// fitted.
  std::vector<double> parameters;
  cv::Mat covariance;  ///< CV_64F, of `parameters`
  std::vector<double> view_rms_px;
  double rms_px = 0.0;    ///< of one coordinate
  double sigma_px = 0.0;  ///< the same, for the degrees of freedom used up
  int points = 0;
  int outliers = 0;  ///< points left out as they were more than 5 sigma off
};

/// How many terms the lens has is chosen by Schwarz's criterion (BIC). The lens' centre is taken to be the
/// photograph's. Fails with a line if a view has less than 9 points or they are on one line.
Result<BoardFit> fit_boards(std::span<const BoardView> views, int width_px, int height_px);

/// The lens and a view's homography for a vector of parameters like BoardFit::parameters.
digitize::LensDistortion lens_of(const BoardFit& fit, std::span<const double> parameters);
cv::Matx33d homography_of(std::span<const double> parameters, std::size_t view);

}  // namespace strobe::camera
