// The rig file's calibration against photographs of a printed board: what its map makes of the board's
// spacing, how much of the view the boards cover, and how well one lens fits them all. Deterministic; no I/O;
// thread-safe; allocates.
#pragma once

#include <span>
#include <string>

#include "common/result.hpp"
#include "host/camera/board.hpp"
#include "host/commission/record/step_result.hpp"
#include "host/digitize/core/plane_map.hpp"

namespace strobe::commission {

/// Of the photograph, by the boards' outlines together; 0 to 1.
double covered_share(std::span<const camera::BoardView> views, int width_px, int height_px);

struct BoardCheck {
  int views = 0;
  double covered = 0.0;      ///< see covered_share()
  double residual_px = 0.0;  ///< of one coordinate of a point, about the board's own fit
  double residual_sd_px = 0.0;
  /// Of the rig file's scale, by the board in the plane where balls fly: 0.01 where it has 1 % too many px a
  /// metre, and its change over the photograph's width and height.
  double scale_off = 0.0, scale_sd = 0.0;
  double across = 0.0, across_sd = 0.0;
  double upwards = 0.0, upwards_sd = 0.0;
};

/// The first view is that of the plane. map and px_per_m: the rig file's. Fails with one line if the boards
/// fit no camera.
Result<BoardCheck> check_board(std::span<const camera::BoardView> views, int width_px, int height_px,
                               const digitize::PlaneMap& map, double px_per_m);

/// By the corners: those of a board of 10 x 7 squares that just fits into the view lie on 57 % of it.
inline constexpr double kMinCovered = 0.4;
/// A flat board's corners are found to 0.1 px; one that is bent, or focused badly, is worse.
inline constexpr double kMaxBoardResidual_px = 0.3;
/// A careful board's print and place leave 0.1 %.
inline constexpr double kMaxBoardScale = 0.004;

StepResult judge_board(const BoardCheck& check);

}  // namespace strobe::commission
