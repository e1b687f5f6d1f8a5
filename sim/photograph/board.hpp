// Photographs of a printed calibration board, through a pinhole with a distorting lens, and where each of its
// points truly is. For trying calibrations. Deterministic by the seed; thread-safe; allocates.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace strobe::sim {

enum class BoardPrint { chessboard, circles, staggered };

struct BoardCamera {
  int width_px = 2592, height_px = 2048;
  double focal_px = 5200.0;  ///< > 0
  /// k1, k2, p1, p2 as in OpenCV, of (x/z, y/z).
  std::array<double, 4> lens{};
  std::array<double, 2> lens_aside_px{};  ///< the lens' centre from the photograph's
  double blur_px = 0.8;                   ///< sd of the lens' blur, >= 0
  double noise = 0.01;                    ///< sd of a pixel, as a share of white
  int bits = 16;                          ///< 8 or 16
};

struct Board {
  BoardPrint print = BoardPrint::chessboard;
  int columns = 9, rows = 6;  ///< inner corners, or discs
  double spacing_m = 0.02;    ///< side of a square; of discs, their distance along a row
};

/// The board's middle in front of the lens, turned about x (down), y (left) and z (in its plane), in that
/// order.
struct BoardPlace {
  double distance_m = 1.0;
  std::array<double, 2> aside_m{};  ///< to the right and down from the optical axis
  std::array<double, 3> turns_deg{};
};

struct BoardPhotograph {
  cv::Mat pixels;                     ///< CV_8UC1 or CV_16UC1
  std::vector<cv::Point2d> board_m;   ///< each point on the board
  std::vector<cv::Point2d> image_px;  ///< and on the photograph; some may be outside of it
};

/// Where a point of the board is seen.
cv::Point2d image_of(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                     cv::Point2d board_m);

/// Where the ray of a place of the photograph meets the board's plane, board metres.
cv::Point2d board_at(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                     cv::Point2d image_px);

BoardPhotograph photograph_board(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                                 std::uint64_t seed);

/// The truth as one JSON object: camera, board, place and points.
std::string board_truth_json(const BoardCamera& camera, const Board& board, const BoardPlace& place,
                             const BoardPhotograph& photograph, const std::string& file);

/// A calibration board seen by a scene's camera, as a lab photographs one before its balls. Pure;
/// thread-safe.
struct BoardView {
  BoardCamera camera;  ///< the scene's: size, scale, the lens's place and distortion
  BoardPlace place;    ///< in the balls' plane, in the middle of the photograph
};

/// A scene whose lens is infinitely far away gets one that is 100 m away: perspective then moves a ball's
/// outline by less than a thousandth of its diameter.
BoardView board_view(const Scene& scene);

}  // namespace strobe::sim
