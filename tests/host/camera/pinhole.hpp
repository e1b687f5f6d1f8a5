// A camera with known truth, written apart from the product's: a pinhole with a lens somewhere in front of
// boards.
#pragma once

#include <opencv2/core.hpp>
#include <random>

#include "host/camera/board.hpp"

namespace strobe::testing {

struct Pinhole {
  int width = 640, height = 480;
  double focal_px = 2500.0;
  double k1 = 0.0, k2 = 0.0;  ///< of the argument (x/z, y/z)
  cv::Point2d centre;         ///< of the lens on the photograph, image px

  cv::Point2d project(cv::Vec3d in_camera) const;
  /// The other way: (x/z, y/z).
  cv::Point2d ray(cv::Point2d image_px) const;
};

/// A board's place: board metres (x, y, 0) to the camera's axes (x right, y down, z away).
struct Pose {
  cv::Matx33d turn;
  cv::Vec3d shift;

  cv::Vec3d to_camera(cv::Point2d board_m) const;
  cv::Point2d foot_m() const;  ///< of the perpendicular from the lens
  double distance_m() const;
};

/// A board with its middle on the optical axis but for `aside`, turned about x, y, z in that order.
Pose pose(const camera::BoardPattern& pattern, double distance_m, cv::Vec3d turns_rad,
          cv::Point2d aside_m = {});

/// Exact points with noise.
camera::BoardView view(const Pinhole& camera, const Pose& pose, const camera::BoardPattern& pattern,
                       double noise_px, std::mt19937_64& random);

/// The photograph: 3 x 3 rays a pixel through a paper that is white around the board, blurred and with noise.
cv::Mat photograph(const Pinhole& camera, const Pose& pose, const camera::BoardPattern& pattern, double noise,
                   std::mt19937_64& random);

}  // namespace strobe::testing
