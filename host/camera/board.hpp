// A printed board on a photograph: where its corners or discs are, to parts of a pixel. Deterministic; no
// I/O; thread-safe; allocates; no exception escapes.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::camera {

enum class BoardKind { chessboard, circles, staggered_circles };

struct BoardPattern {
  BoardKind kind = BoardKind::chessboard;
  int columns = 9;  ///< of inner corners, or of discs; 3 to 100
  int rows = 6;     ///< 3 to 100
  /// Side of a square; of discs, their distance. Staggered: half of that along a row.
  double spacing_m = 0.02;
};

/// "chessboard 9 x 6, 20 mm"
std::string describe(const BoardPattern& pattern);

/// Its points in metres, row by row from one corner.
std::vector<cv::Point2d> board_points(const BoardPattern& pattern);

/// A board as it was seen: its points in metres on the board, and on the photograph in image px.
struct BoardView {
  std::string name;  ///< the photograph's
  std::vector<cv::Point2d> board_m;
  std::vector<cv::Point2d> image_px;
};

/// Corners by OpenCV's detector, refined by the gradients around each on the photograph at full size
/// (Förstner); discs by the centroid of their darkness. Fails with "NAME: what": the whole board must be
/// seen.
Result<BoardView> find_board(const digitize::Photograph& photograph, const BoardPattern& pattern);

}  // namespace strobe::camera
