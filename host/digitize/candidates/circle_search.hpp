// Circles through the edge points of a picture: edge points vote for the centres that their gradients point
// to (Hough transform for circles), and the circles that most of them support are taken first. Deterministic
// for any number of threads; thread-safe; allocates.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

namespace strobe::digitize {

// Edge points: where intensity changes most steeply. Deterministic; thread-safe; allocates.

/// In px of the picture.
struct EdgePoint {
  cv::Point2f at;
  cv::Point2f normal;  ///< unit vector towards the brighter side
};

struct EdgeDetection {
  double neighbourhood_px = 32.0;  ///< of the local threshold: about the ball's radius
  double prominence = 1.8;         ///< threshold over the typical gradient around
  double floor = 0.0;              ///< least gradient, intensity per px
};

/// `intensity`: CV_32FC1. Local maxima of the gradient along its direction (Canny 1986), with sub-pixel
/// positions by a parabola. The threshold follows the gradients around and not the brightness, so that faint
/// and bright images count alike.
std::vector<EdgePoint> find_edge_points(const cv::Mat& intensity, const EdgeDetection& detection);

// Edge points in support of a circle, and the circle that fits them. Deterministic; a CircleSupport may be
// read by many threads and claimed from by one; allocates.

struct Circle {
  cv::Point2d centre;
  double radius = 0.0;
};

inline constexpr std::size_t kSectors = 72;  ///< of a circle, by which edge points are counted
inline constexpr double kSectorOfCircle = 1.0 / kSectors;

struct SupportedCircle {
  Circle circle;
  double coverage = 0.0;  ///< fraction of the circle with edge points, isolated ones not counted
};

/// Edge points in square cells, so that those near a circle are found without visiting all.
class CircleSupport {
 public:
  CircleSupport(const std::vector<EdgePoint>& edges, cv::Size size);

  /// Least squares of centre and radius to unclaimed edge points with normals along the radius, from `start`,
  /// within a band that narrows. The radius stays within the bounds.
  SupportedCircle fit(const Circle& start, double radius_min, double radius_max) const;

  /// Removes the circle's edge points from later fits.
  void claim(const Circle& circle);

  /// Gives all that was claimed back.
  void release();

 private:
  template <typename Visit>
  void visit_ring(const Circle& circle, double band, Visit visit) const;

  std::vector<EdgePoint> edges_;      // by cell
  std::vector<std::uint32_t> first_;  // of each cell; one more at the end
  std::vector<unsigned char> claimed_;
  int columns_ = 0, rows_ = 0;
};

/// In px of the picture that the edge points are from.
struct CircleSearch {
  double radius_min = 0.0;
  double radius_max = 0.0;
  double min_coverage = 0.0;    ///< smallest visible fraction of an outline
  std::size_t max_peaks = 250;  ///< of the votes, highest first, at which a circle is fitted
};

/// Best first when found, at least a tenth of the radius apart; none shares its edge points with a better
/// one. `support` is made of `edges`, whose picture has that size; afterwards the circles' edge points are
/// claimed.
std::vector<SupportedCircle> find_circles(const std::vector<EdgePoint>& edges, CircleSupport& support,
                                          cv::Size size, const CircleSearch& search);

}  // namespace strobe::digitize
