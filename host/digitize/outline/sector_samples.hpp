// The photograph sampled across one outline, cut into short sectors. Intensity is sampled along rays across
// the outline and averaged over each sector's rays. Deterministic; thread-safe; allocates.
#pragma once

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

// The plane around one ball as a photograph's pixels sample it, and the ball's outline there. Local
// coordinates: axes as in the plane (y up), one unit is an image pixel at the origin, a point of the plane.
// The map to the photograph is approximated by a cubic polynomial, so that thousands of samples cost little.
// Plain values; thread-safe; no allocation.

class LocalFrame {
 public:
  /// Valid within `reach_px` of the centre.
  LocalFrame(const PlaneMap& map, cv::Point2d centre_image, double reach_px);

  /// Exact without a calibration.
  cv::Point2d to_image(cv::Point2d local_px) const {
    if (uncalibrated_) return {centre_image_.x + local_px.x, centre_image_.y - local_px.y};
    const double u = local_px.x / reach_px_, v = local_px.y / reach_px_;
    return {at(column_, u, v), at(row_, u, v)};
  }
  cv::Point2d from_plane(cv::Point2d plane_px) const { return (plane_px - origin_) * scale_; }
  cv::Point2d to_plane(cv::Point2d local_px) const { return origin_ + local_px * (1.0 / scale_); }
  bool is_uncalibrated() const { return uncalibrated_; }
  double scale() const { return scale_; }  ///< local px per plane px

 private:
  static constexpr int kTerms = 10;
  using Cubic = std::array<double, kTerms>;
  static double at(const Cubic& cubic, double u, double v);

  bool uncalibrated_;
  cv::Point2d centre_image_;
  cv::Point2d origin_;
  double scale_ = 1.0;
  double reach_px_;
  Cubic column_{}, row_{};  ///< image px, of the local offset over the reach
};

/// A ball's outline in a LocalFrame: a circle, or the given ellipse where perspective is known, with a small
/// ovality.
struct OutlineShape {
  cv::Point2d centre;
  double radius = 0.0;
  /// Ovality: the radius' deviation is oval_cos·cos 2θ + oval_sin·sin 2θ [px].
  double oval_cos = 0.0, oval_sin = 0.0;
  /// The perspective ellipse: semi-axes over the radius, their product 1, and the longer one's direction.
  double along = 1.0, across = 1.0;
  cv::Point2d axis{1.0, 0.0};
  double rise = 0.0;  ///< of light over its limb; 0: not known

  /// Distance of the outline from the centre in the direction (c, s), a unit vector.
  double radius_towards(double c, double s) const {
    double r = radius;
    if (along != across) {
      const double u = (c * axis.x + s * axis.y) / along, v = (s * axis.x - c * axis.y) / across;
      r /= std::sqrt(u * u + v * v);
    }
    return r + oval_cos * (c * c - s * s) + oval_sin * 2.0 * c * s;
  }

  /// Depth of a point inside the outline along its ray from the centre [px].
  double depth(cv::Point2d at) const {
    const double x = at.x - centre.x, y = at.y - centre.y;
    const double d = std::sqrt(x * x + y * y);
    return d > 0.0 ? radius_towards(x / d, y / d) - d : radius;
  }
};

/// Where an outline is sampled.
struct SectorGrid {
  int sectors = 0;
  int rays = 0;             ///< of each sector
  double outside_px = 0.0;  ///< from the outline outwards
  double inside_px = 0.0;
};

/// Mean intensity of each sector by depth below the outline.
class SectorSamples {
 public:
  static constexpr int kMaxDepths = 64;

  SectorSamples(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
                const SectorGrid& grid);

  int count() const { return static_cast<int>(sectors_.size()); }
  double saturated_fraction(int index) const { return sector(index).saturated; }
  /// Fraction of the sector that lies on the photograph.
  double inside_fraction(int index) const { return sector(index).inside; }
  /// Whether no saturated sample is that close to the outline.
  bool clear_of_saturation(int index, double within_px) const {
    return sector(index).saturated_inside > within_px && sector(index).saturated_outside < -within_px;
  }
  cv::Point2d direction(int index) const { return sector(index).out; }  ///< of its middle, unit vector
  double window_px() const { return window_; }  ///< larger of the grid's outside_px and inside_px
  double half_width_rad() const;

  /// The depths at which the sector can be used.
  struct Profile {
    double depth_px = 0.0;             ///< of the first, below the outline that was sampled
    std::span<const float> intensity;  ///< from there inwards, every depth_step_px()
  };
  Profile profile(int index) const;
  double depth_step_px() const { return step_; }
  /// Distance from the centre at that depth.
  double radius_px(int index, double depth_px) const { return sector(index).radius - depth_px; }
  /// Its middle on the outline that was sampled.
  cv::Point2d middle(int index) const { return sector(index).middle; }

 private:
  struct Sector {
    cv::Point2d out, middle;
    double radius = 0.0;
    int first = 0, size = 0;  ///< of the usable depths
    double saturated = 0.0;
    double inside = 0.0;
    double saturated_inside = 1e9, saturated_outside = -1e9;  ///< depths nearest to the outline
  };
  const Sector& sector(int index) const { return sectors_[static_cast<std::size_t>(index)]; }
  double depth_px(int sample) const { return sample * step_ - outside_; }
  void sample(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape, int index,
              int rays, std::vector<char>& flawed);
  void choose_depths(Sector& own, const std::vector<char>& flawed) const;

  std::vector<Sector> sectors_;
  std::vector<float> intensity_;  ///< by sector and depth, outermost first
  int depths_ = 0;
  double step_ = 1.0;
  double outside_;
  double window_;
};

}  // namespace strobe::digitize
