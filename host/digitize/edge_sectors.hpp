// The edge of one outline, cut into short stretches ("sectors"). In each, the light of the pixels across the
// edge is fitted by a background that varies linearly, a blurred step and a blurred root (edge_profile.hpp),
// the same for neighbours' outlines that cross it; what these linear terms leave tells how far the outline is
// from where it is thought to be and whether the blur is right (variable projection, Golub and Pereyra 1973,
// in Kaufman's form). Deterministic; thread-safe; allocates.
#pragma once

#include <span>
#include <vector>

#include "host/digitize/local_frame.hpp"
#include "host/digitize/outline_shape.hpp"
#include "host/digitize/photograph.hpp"

namespace strobe::digitize {

/// Pixels by the sector that they belong to.
class SectorPixels {
 public:
  struct Pixel {
    float x, y, light;  ///< local px
  };
  /// Those with a depth between -outside_px and inside_px.
  SectorPixels(const Photograph& photograph, const LocalFrame& frame, const OutlineShape& shape, int sectors,
               double outside_px, double inside_px);

  int count() const { return static_cast<int>(sectors_.size()); }
  std::span<const Pixel> sector(int index) const { return sectors_[static_cast<std::size_t>(index)].pixels; }
  double saturated_share(int index) const { return sectors_[static_cast<std::size_t>(index)].saturated; }
  /// Share of the sector's pixels that the photograph has.
  double present_share(int index) const { return sectors_[static_cast<std::size_t>(index)].present; }
  /// No saturated pixel is that near to the outline.
  bool clear_of_saturation(int index, double within_px) const {
    const Sector& sector = sectors_[static_cast<std::size_t>(index)];
    return sector.saturated_inside > within_px && sector.saturated_outside < -within_px;
  }
  cv::Point2d direction(int index) const;
  double angle(int index) const;  ///< of its middle
  double window_px() const { return window_; }

 private:
  struct Sector {
    std::vector<Pixel> pixels;
    double saturated = 0.0;
    double present = 0.0;
    double saturated_inside = 1e9, saturated_outside = -1e9;  ///< depths nearest to the outline
  };
  std::vector<Sector> sectors_;
  double window_;
};

/// What one sector tells.
struct SectorEdge {
  bool usable = false;        ///< there is an edge, brighter inside
  double offset_px = 0.0;     ///< of the true outline, outwards
  double sd_px = 0.0;         ///< of it, from the pixels' scatter
  double sigma_change = 0.0;  ///< times sigma_weight: what the blur should change by
  double sigma_weight = 0.0;
  double rise = 0.0;  ///< of light, at two sigma inside
};

SectorEdge fit_sector(const SectorPixels& pixels, int index, const OutlineShape& shape,
                      std::span<const OutlineShape> neighbours, double sigma_px);

}  // namespace strobe::digitize
