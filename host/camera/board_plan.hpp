// Where the next photograph of a board helps most: of placements all over the view, how uncertain the scale's
// map would be after each, from the fit's own information (as mrcal's dance-study does). A board away from
// the balls' plane has a homography of its own, so that it tells of the lens alone: where it lies in the view
// matters. Deterministic; thread-safe; allocates; no I/O.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/camera/board.hpp"
#include "host/camera/calibration.hpp"

namespace strobe::camera {

enum class NearerSide { left, right, upper, lower };  ///< as seen on the photograph

struct BoardPlacement {
  int across = 0;               ///< -1, 0, 1: at the photograph's left border, in its middle, at the right
  int down = 0;                 ///< likewise, 1 at the lower border
  double distance_share = 1.0;  ///< of the lens' distance from the balls' plane
  double slant_rad = 0.0;       ///< against a board square to the optical axis
  NearerSide nearer = NearerSide::left;
};

struct PlannedBoard {
  BoardPlacement placement;
  cv::Point2d middle_px;                ///< of the board, image px; before the lens distorts
  std::vector<cv::Point2d> outline_px;  ///< of all squares: upper left corner first, clockwise on the board
  cv::Matx33d homography;               ///< like BoardFit::homographies
  double scale_sd_share = 0.0;          ///< ScaleErrors::points with it
};

struct BoardPlan {
  double scale_sd_share = 0.0;  ///< ScaleErrors::points so far
  double limit_share = 0.0;  ///< what it would be if the lens were known: no further photograph does better
  double distance_m = 0.0;   ///< of the lens from the balls' plane, as used
  bool distance_known = false;     ///< else a usual lens was assumed, and slants look a little different
  std::vector<PlannedBoard> next;  ///< one after the other, each given those before; their sd only falls
  /// Of the lens' distance, so far and with all of them; absent: by more than a quarter of it.
  std::optional<double> distance_sd_m, next_distance_sd_m;
};

/// Every placement in which the whole board is seen: the photograph's nine places, 0.8 to 1.6 times the
/// plane's distance, slanted by 20 and 30 degrees to four sides. The best first.
std::vector<PlannedBoard> rank_placements(const Calibration& found, const BoardPattern& pattern,
                                          const CalibrationSettings& settings);

/// The best `count` photographs, one after the other; fewer where the board is seen as a whole nowhere.
BoardPlan plan_boards(const Calibration& found, const BoardPattern& pattern,
                      const CalibrationSettings& settings, int count);

/// "slanted by 30 degrees, its left side nearer, in the upper right corner, 1.25 times as far as the balls'
/// plane"
std::string describe(const BoardPlacement& placement);

/// The photograph's frame, the boards so far, dotted, and the planned outlines with their numbers, as an SVG
/// that stands alone.
std::string plan_svg(const BoardPlan& plan, const Calibration& found, const BoardPattern& pattern,
                     const CalibrationSettings& settings);

}  // namespace strobe::camera
