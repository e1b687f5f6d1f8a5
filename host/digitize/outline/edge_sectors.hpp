// The edge of one outline, cut into short stretches ("sectors"). The light is sampled along rays across the
// edge and averaged over each sector's rays. Each sector's profile is fitted by a background that varies
// linearly, a blurred step and a blurred root (edge_profile.hpp), the same for neighbours' outlines that
// cross it; what these linear terms leave tells how far the outline is from where it is thought to be and
// whether the blur is right (variable projection, Golub and Pereyra 1973, in Kaufman's form). Deterministic;
// thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/core/local_frame.hpp"
#include "host/digitize/image/photograph.hpp"
#include "host/digitize/outline/edge_profile.hpp"
#include "host/digitize/outline/outline_shape.hpp"

namespace strobe::digitize {

/// Where the light of an outline is sampled.
struct SectorGrid {
  int sectors = 0;
  int rays = 0;             ///< of each sector
  double outside_px = 0.0;  ///< from the outline outwards
  double inside_px = 0.0;
};

/// Mean light of each sector by depth.
class SectorLight {
 public:
  SectorLight(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape,
              const SectorGrid& grid);

  int count() const { return static_cast<int>(sectors_.size()); }
  double saturated_fraction(int index) const { return sector(index).saturated; }
  /// Share of the sector that the photograph has.
  double inside_fraction(int index) const { return sector(index).present; }
  /// No saturated pixel is that near to the outline.
  bool clear_of_saturation(int index, double within_px) const {
    return sector(index).saturated_inside > within_px && sector(index).saturated_outside < -within_px;
  }
  cv::Point2d direction(int index) const { return sector(index).out; }
  double angle(int index) const;  ///< of its middle
  double window_px() const { return window_; }
  double half_width_rad() const;

  /// The depths at which the sector's light can be used: from `first`, `size` of them.
  struct Profile {
    double depth_px = 0.0;  ///< of the first, below the outline that was given
    std::span<const float> light;
  };
  Profile profile(int index) const;
  double depth_step_px() const { return step_; }
  /// From the centre, at that depth.
  double reach_px(int index, double depth_px) const { return sector(index).reach - depth_px; }
  /// On the outline that was given.
  cv::Point2d middle(int index) const { return sector(index).middle; }

 private:
  struct Sector {
    cv::Point2d out, middle;
    double reach = 0.0;
    int first = 0, size = 0;  ///< of what can be used
    double saturated = 0.0;
    double present = 0.0;
    double saturated_inside = 1e9, saturated_outside = -1e9;  ///< depths nearest to the outline
  };
  const Sector& sector(int index) const { return sectors_[static_cast<std::size_t>(index)]; }
  void sample(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape, int index,
              int rays, std::vector<int>& flawed);

  std::vector<Sector> sectors_;
  std::vector<float> light_;  ///< by sector and depth, outermost first
  int depths_ = 0;
  double step_ = 1.0;
  double outside_;
  double window_;
};

/// What one sector tells.
struct SectorEdge {
  bool usable = false;        ///< there is an edge, brighter inside
  double offset_px = 0.0;     ///< of the true outline, outwards
  double sd_px = 0.0;         ///< of it, from the pixels' scatter
  double sigma_change = 0.0;  ///< times sigma_weight: what the blur should change by
  double sigma_weight = 0.0;
  bool no_edge = false;  ///< light does not rise at the outline though it could be seen to
  double fading = 0.0;   ///< light that the limb's rounding adds over a blur's width to that at the limb
  double offset_by_sigma = 0.0;  ///< what the offset changes by as the blur grows
};

/// The profiles that fit_sector() needs of an outline of that radius and blur.
ProfileTable sector_profiles(const SectorLight& light, double radius_px, double sigma_px);

/// `rough`: the shape may still be off by more than a px.
SectorEdge fit_sector(const SectorLight& light, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, const ProfileTable& profiles, double sigma_px,
                      bool rough);

}  // namespace strobe::digitize
