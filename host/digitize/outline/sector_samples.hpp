// The photograph sampled across one outline, cut into short sectors. Intensity is sampled along rays across
// the outline and averaged over each sector's rays. Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outline/local_frame.hpp"

namespace strobe::digitize {

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
