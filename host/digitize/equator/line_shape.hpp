// The width and blur of the equator line, from the intensity across it. Thread-safe; allocates.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host/digitize/equator/ball_pixels.hpp"

namespace strobe::digitize {

/// A pixel near a line, in unit coordinates.
struct LinePoint {
  float u = 0.0F, v = 0.0F, z = 0.0F;
  float x = 0.0F;       ///< residual over the ball's shading
  float weight = 0.0F;  ///< inverse variance of x, up to a common factor
};

std::vector<LinePoint> points_near(BallPixels& pixels, const EquatorLine& line);

/// Weighted sums of the residuals across a line.
struct LineProfile {
  static constexpr int kBins = 81;
  std::array<double, kBins> sum{};
  std::array<double, kBins> weight{};

  void add(std::span<const LinePoint> points, const EquatorLine& line);
  void add(const LineProfile& other);
};

/// A grid of line shapes that are compared with profiles.
class ShapeGrid {
 public:
  static constexpr double kHalfWidthStep = 1.25;  ///< from one half width to the next
  /// Of the true half width, relative: uniform between two of the grid.
  static constexpr double kHalfWidthSd = (kHalfWidthStep - 1.0) / 3.4641;  // root of 12
  /// `radius`: the ball's in bins, which limit how sharp a line can look.
  explicit ShapeGrid(double radius);
  /// The shape with the least squares, of those that are darker than their surroundings.
  LineShape best(const LineProfile& profile) const;

 private:
  struct Trial {
    LineShape shape;
    std::array<double, LineProfile::kBins> darkness{};
  };
  std::vector<Trial> trials_;
};

}  // namespace strobe::digitize
