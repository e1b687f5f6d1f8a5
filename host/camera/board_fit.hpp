// From the boards' points to lens and homographies, by least squares: each photograph's board is mapped by a
// homography of its own to the ideal photograph, which one lens then distorts. Nothing need be known of the
// focal length, so that a single photograph will do. Deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <vector>

#include "common/result.hpp"
#include "host/camera/board.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::camera {

struct BoardFit {
  /// Unit of the normalized photograph: (image px - lens.centre_px)/lens.focal_px.
  digitize::LensDistortion lens;
  /// Of k1, k2, p1, p2: those that the boards tell better than what is known of lenses does.
  int lens_terms = 0;
  std::vector<cv::Matx33d> homographies;  ///< board [m] to normalized ideal photograph, (2, 2) = 1
  /// Of all parameters: 8 for each homography (row by row, without the last), then k1, k2, p1, p2.
  std::vector<double> parameters;
  cv::Mat covariance;  ///< CV_64F, of `parameters`
  std::vector<double> view_rms_px;
  double rms_px = 0.0;    ///< of one coordinate
  double sigma_px = 0.0;  ///< the same, for the degrees of freedom used up
  int points = 0;
  int outliers = 0;  ///< points left out as they were more than 5 sigma off
};

/// What is known of lenses before any board: the sds of k1, k2, p1, p2, each about 0. With them all four
/// terms are fitted. One that the board does not reach far enough to tell stays near 0, and its sd says what
/// the corners may be off; chosen by a criterion it would be taken for known, in or out.
inline constexpr std::array<double, 4> kLensPriorSds{
    0.1,    // 2.5 % of the radius at the corners, as ordinary photographic lenses have
    0.16,   // 1 % there
    0.001,  // 0.15 %: elements off centre, and the lens' own centre beside the photograph's by 0.4 % of the
            // diagonal
    0.001};

/// All terms with their priors. The lens' centre is taken to be the photograph's. Fails with a line if a view
/// has less than 9 points or they are on one line.
Result<BoardFit> fit_boards(std::span<const BoardView> views, int width_px, int height_px);

/// The lens and a view's homography for a vector of parameters like BoardFit::parameters.
digitize::LensDistortion lens_of(const BoardFit& fit, std::span<const double> parameters);
cv::Matx33d homography_of(std::span<const double> parameters, std::size_t view);

// What one more photograph would tell, before it is taken: its points where the fit has them, found as well
// as those so far. The information of all is that of the same equations, with the new homography eliminated
// (Schur complement). Deterministic; thread-safe.

/// Of fit.parameters, once a view of the board's points by this homography is among the photographs.
cv::Mat covariance_with(const BoardFit& fit, std::span<const cv::Point2d> board_m,
                        const cv::Matx33d& homography);

/// The fit with that view, its homography known as well as it would be then. Its residuals are of before.
BoardFit with_planned_view(const BoardFit& fit, std::span<const cv::Point2d> board_m,
                           const cv::Matx33d& homography);

}  // namespace strobe::camera
