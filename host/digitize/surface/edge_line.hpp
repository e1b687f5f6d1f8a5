// A straight edge with sub-pixel accuracy: the steepest rise of many profiles across it, and the line that
// they agree on. Deterministic; thread-safe; allocates.
#pragma once

#include <algorithm>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

// Straight edges across a photograph, brighter below: a Hough transform in which edge points vote for lines
// along their own direction only (O'Gorman and Clowes 1976). Deterministic; thread-safe; allocates.

/// row = row_px + slope·(column - middle of the photograph), image px.
struct HoughLine {
  double row_px = 0.0;
  double slope = 0.0;
  double votes = 0.0;  ///< over the photograph's width
};

/// The parts of a photograph that balls cover.
struct OcclusionMask {
  cv::Mat mask;        ///< CV_8UC1, non-zero: covered; empty: none is
  double scale = 1.0;  ///< photograph px per mask px

  bool at(int column, int row) const {
    return !mask.empty() && mask.at<uchar>(std::min(static_cast<int>(row / scale), mask.rows - 1),
                                           std::min(static_cast<int>(column / scale), mask.cols - 1)) != 0;
  }
};

/// Size of the downsampled picture in which lines are searched.
cv::Size hough_image_size(cv::Size photograph);

/// Most votes first. `occluded`: of hough_image_size(), or empty; edge points there do not vote.
std::vector<HoughLine> hough_lines(const Photograph& photograph, const OcclusionMask& hidden,
                                   std::size_t most);

// Light on a line of pixels down across a nearly level edge. Deterministic; thread-safe; no allocation.

inline constexpr int kProfileHalfReach_px = 10;
inline constexpr int kProfileColumns = 5;  ///< averaged for one profile; odd
inline constexpr int kMaxProfiles = 240;   ///< along an edge
/// Nearer to a line a crossing belongs to it.
inline constexpr double kInlier_px = 1.5;
/// Of the level of saturation: noise and compression leave saturated pixels a little below it.
inline constexpr double kSaturatedShare = 0.985;

/// What no residual along a straight edge shows, as how the lens blurs it: the likeliest on photographs of 24
/// looks by each of both renderers, on which errors over sds are then 1.06 and 1.00.
inline constexpr double kEdgeFloor_px = 0.035;

struct EdgeSamples {
  int top = 0;  ///< row of the first
  std::array<double, 2 * kProfileHalfReach_px + 1> intensity{};
};

/// How many profiles are taken across an edge that crosses the photograph, and the middle column of each.
int profile_count(const Photograph& photograph);
int profile_column(const Photograph& photograph, int profile);

/// Means over kProfileColumns, from the edge's row upwards and downwards. Returns nullopt where the edge is
/// occluded or not on the photograph. A mean with a saturated pixel in it is one: kSaturatedShare of
/// saturation or more.
std::optional<EdgeSamples> samples_across(const Photograph& photograph, const OcclusionMask& occluded,
                                          int column, double row);

struct EdgeLine {
  cv::Point2d middle;             ///< plane px, in the middle of what was seen
  double slope = 0.0;             ///< plane px, y up
  double half_span = 0.0;         ///< of x, px
  double visible_fraction = 0.0;  ///< inliers among the profiles that are not occluded
  double visible_px = 0.0;        ///< length
  double sd_px = 0.0;             ///< of the height at the middle
  double slope_sd = 0.0;
  double contrast = 0.0;  ///< median rise of intensity

  double at(double x) const { return middle.y + slope * (x - middle.x); }
};

/// Returns nullopt for fewer than 12 inliers.
std::optional<EdgeLine> fit_edge_line(const Photograph& photograph, const PlaneMap& map,
                                      const OcclusionMask& occluded, const HoughLine& start);

}  // namespace strobe::digitize
