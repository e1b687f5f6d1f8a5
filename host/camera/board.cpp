#include "host/camera/board.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace strobe::camera {
namespace {

/// The detectors need no more, and take seconds on more.
constexpr int kDetectWidth = 1600;

/// 8 bit over the range of the light, and not wider than the detectors need.
cv::Mat for_detection(const cv::Mat& light, double& scale) {
  double least = 0.0, most = 0.0;
  cv::minMaxLoc(light, &least, &most);
  const double range = std::max(most - least, 1e-9);
  cv::Mat small = light;
  scale = std::min(1.0, static_cast<double>(kDetectWidth) / std::max(light.cols, light.rows));
  if (scale < 1.0) cv::resize(light, small, {}, scale, scale, cv::INTER_AREA);
  cv::Mat bytes;
  small.convertTo(bytes, CV_8U, 255.0 / range, -least * 255.0 / range);
  return bytes;
}

bool detect(const cv::Mat& bytes, const BoardPattern& pattern, std::vector<cv::Point2f>& points) {
  const cv::Size size(pattern.columns, pattern.rows);
  switch (pattern.kind) {
    case BoardKind::chessboard:
      return cv::findChessboardCorners(
                 bytes, size, points,
                 cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK) ||
             cv::findChessboardCornersSB(bytes, size, points,
                                         cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_EXHAUSTIVE);
    case BoardKind::circles:
    case BoardKind::staggered_circles: {
      cv::SimpleBlobDetector::Params look;
      look.maxArea = 0.02F * static_cast<float>(bytes.total());
      look.minDistBetweenBlobs = 5.0F;
      const int grid =
          pattern.kind == BoardKind::circles ? cv::CALIB_CB_SYMMETRIC_GRID : cv::CALIB_CB_ASYMMETRIC_GRID;
      return cv::findCirclesGrid(bytes, size, points, grid | cv::CALIB_CB_CLUSTERING,
                                 cv::SimpleBlobDetector::create(look));
    }
  }
  return false;
}

double least_distance(const std::vector<cv::Point2f>& points) {
  double least = 1e9;
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, cv::norm(points[i] - points[j]));
  }
  return least;
}

void refine_corners(const cv::Mat& light, std::vector<cv::Point2f>& points) {
  const int half = std::clamp(static_cast<int>(0.3 * least_distance(points)), 2, 25);
  const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 60, 1e-4);
  // Gradients of the noise alone would blur the result; those of the corners are far wider.
  cv::Mat calm;
  cv::GaussianBlur(light, calm, {0, 0}, std::clamp(0.1 * half, 0.5, 1.5));
  cv::cornerSubPix(calm, points, {half, half}, {-1, -1}, until);
}

/// Centroid of what is darker than half way from the paper to the disc, weighted by how much.
cv::Point2f centroid(const cv::Mat& light, cv::Point2f start, double half) {
  cv::Point2d centre = start;
  for (int step = 0; step < 5; ++step) {
    const cv::Rect around(static_cast<int>(std::floor(centre.x - half)),
                          static_cast<int>(std::floor(centre.y - half)), static_cast<int>(2.0 * half) + 2,
                          static_cast<int>(2.0 * half) + 2);
    const cv::Rect box = around & cv::Rect(0, 0, light.cols, light.rows);
    if (box.area() < 9) return start;
    double dark = 0.0, bright = 0.0;
    cv::minMaxLoc(light(box), &dark, &bright);
    // Ramp from 25 to 75 per cent: the edge counts by its share, paper's and print's noise not at all.
    const double low = dark + 0.25 * (bright - dark), range = std::max(0.5 * (bright - dark), 1e-9);
    double sum = 0.0, x = 0.0, y = 0.0;
    for (int row = box.y; row < box.y + box.height; ++row) {
      for (int col = box.x; col < box.x + box.width; ++col) {
        if (std::hypot(col - centre.x, row - centre.y) > half) continue;
        const double weight = 1.0 - std::clamp((light.at<float>(row, col) - low) / range, 0.0, 1.0);
        sum += weight;
        x += weight * col;
        y += weight * row;
      }
    }
    if (!(sum > 0.0)) return start;
    centre = {x / sum, y / sum};
  }
  return centre;
}

void refine_discs(const cv::Mat& light, std::vector<cv::Point2f>& points) {
  const double half = 0.5 * least_distance(points);
  for (cv::Point2f& point : points) point = centroid(light, point, half);
}

cv::Point2d place(const BoardPattern& pattern, int column, int row) {
  if (pattern.kind == BoardKind::staggered_circles) {
    return {0.5 * pattern.spacing_m * (2 * column + row % 2), 0.5 * pattern.spacing_m * row};
  }
  return {pattern.spacing_m * column, pattern.spacing_m * row};
}

Result<BoardView> find(const digitize::Photograph& photograph, const BoardPattern& pattern) {
  double scale = 1.0;
  const cv::Mat bytes = for_detection(photograph.intensity, scale);
  std::vector<cv::Point2f> points;
  if (!detect(bytes, pattern, points)) {
    return fail(fmt::format("{}: no {} is seen as a whole", photograph.name, describe(pattern)));
  }
  // Shrinking by areas keeps pixels' borders in place, not their centres.
  const auto up = static_cast<float>(1.0 / scale);
  for (cv::Point2f& p : points) p = {(p.x + 0.5F) * up - 0.5F, (p.y + 0.5F) * up - 0.5F};
  pattern.kind == BoardKind::chessboard ? refine_corners(photograph.intensity, points)
                                        : refine_discs(photograph.intensity, points);
  BoardView view;
  view.name = photograph.name;
  view.board_m = board_points(pattern);
  view.image_px.assign(points.begin(), points.end());
  return view;
}

}  // namespace

std::vector<cv::Point2d> board_points(const BoardPattern& pattern) {
  std::vector<cv::Point2d> points;
  for (int row = 0; row < pattern.rows; ++row) {
    for (int column = 0; column < pattern.columns; ++column) points.push_back(place(pattern, column, row));
  }
  return points;
}

std::string describe(const BoardPattern& pattern) {
  const char* kind = pattern.kind == BoardKind::chessboard ? "chessboard"
                     : pattern.kind == BoardKind::circles  ? "circle grid"
                                                           : "staggered circle grid";
  return fmt::format("{} {} x {}, {} mm", kind, pattern.columns, pattern.rows, pattern.spacing_m * 1e3);
}

Result<BoardView> find_board(const digitize::Photograph& photograph, const BoardPattern& pattern) {
  try {
    return find(photograph, pattern);
  } catch (const cv::Exception& error) {
    return fail(photograph.name + ": the search for the board failed: " + error.err);
  }
}

}  // namespace strobe::camera
