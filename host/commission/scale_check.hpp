// The ball's own size on the photograph against the calibrated scale and the ball as measured, and how it
// changes over the photograph: a wrong scale or ball shows as a ratio, a camera that is not square to the
// plane as a slope. Deterministic; no I/O; thread-safe; allocates.
#pragma once

#include <Eigen/Core>
#include <span>

#include "common/reduction/frame.hpp"
#include "common/result.hpp"
#include "host/commission/record/step_result.hpp"

namespace strobe::commission {

/// The logarithm of a length seen over the true one, at a place of the photograph.
struct Size {
  double across, upwards;  ///< from the photograph's middle, over its width and height
  double log_ratio;
  double weight = 1.0;  ///< inverse variance, or 1
};

struct SizePlane {
  Eigen::Vector3d terms;  ///< middle, across, upwards
  Eigen::Matrix3d covariance;
};

/// Weighted least squares. Residuals make the covariance larger than that of unit variance by their mean
/// square, but not by less than least_square.
SizePlane fit_plane(std::span<const Size> sizes, double least_square);

struct ScaleCheck {
  double ratio = 1.0;     ///< diameter seen over scale times diameter stated
  double ratio_sd = 0.0;  ///< of the images, from shot to shot
  /// Change of the size across the photograph's whole width and height, as a share, and their sds.
  double across = 0.0, across_sd = 0.0;  ///< left to right
  double upwards = 0.0, upwards_sd = 0.0;
  int images = 0, shots = 0;
};

/// Images in the air, of frames in plane px of a photograph of that size. Fails with one line where fewer
/// than 8 images are there.
Result<ScaleCheck> check_scale(std::span<const reduction::Frame> frames, double px_per_m,
                               double ball_diameter_m, double width_px, double height_px);

/// The ball's size against scale and diameter; diameter_share_sd and scale_share_sd as the rig file states
/// them.
StepResult judge_scale(const ScaleCheck& check, double diameter_share_sd, double scale_share_sd);
/// Change of the ball's size over the photograph.
StepResult judge_squareness(const ScaleCheck& check);

}  // namespace strobe::commission
