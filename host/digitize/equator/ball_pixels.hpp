// One ball's pixels, row by row, with the background, its own shading and its neighbours' subtracted: what
// remains is drawn on the ball. One thread at a time; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/equator/shading.hpp"

namespace strobe::digitize {

/// Another ball whose disc overlaps, with its line if that is to be subtracted too.
struct Neighbour {
  std::size_t ball = 0;
  std::optional<EquatorLine> line;
};

class BallPixels {
 public:
  /// A bin under the ball.
  struct Pixel {
    float u = 0.0F, v = 0.0F, z = 0.0F;
    float residual = 0.0F;  ///< of the intensity, less background and shadings
    float shading = 0.0F;   ///< the ball's
    float variance = 0.0F;  ///< relative: sum of the squared shadings, as the felts' grain adds up
    bool saturated = false;
    bool usable = false;  ///< neither saturated nor in the ring around an outline
  };

  BallPixels(const BinnedImage& image, std::span<const Disc> discs, std::span<const Shading> shadings,
             std::size_t ball, std::span<const Neighbour> neighbours);

  const Disc& disc() const { return *disc_; }
  const Shading& shading() const { return *shading_; }
  int stride() const { return image_->stride; }
  /// Shading below which the ball is too dark to use.
  float floor() const { return floor_; }

  /// Rows of the disc of that many radii.
  cv::Range rows(double radii) const;
  /// The bins of a row within that many radii and, with `band`, within that distance of a line through the
  /// middle. Valid until the next call.
  struct Band {
    double angle_rad = 0.0;
    double within = 1.0;  ///< radii
  };
  std::span<const Pixel> row(int j, double radii, const std::optional<Band>& band = {});

 private:
  struct Other {
    const Disc* disc;
    const Shading* shading;
    std::optional<LineCoordinates> place;
    std::optional<ShapeTable> shape;
    double contrast = 0.0;
  };
  void subtract(const Other& other, int j, int start);

  const BinnedImage* image_;
  const Disc* disc_;
  const Shading* shading_;
  float floor_;
  std::vector<Other> others_;
  std::vector<Pixel> row_;
  std::vector<float> background_;
  std::vector<float> count_;
};

// The width and blur of the equator line, from the intensity across it. Thread-safe; allocates.

/// A pixel near a line, in unit coordinates.
struct LinePoint {
  float u = 0.0F, v = 0.0F, z = 0.0F;
  cv::Point2f slope;    ///< of the shading's logarithm, per radius
  float x = 0.0F;       ///< residual over the ball's shading
  float weight = 0.0F;  ///< inverse variance of x, up to a common factor
};

std::vector<LinePoint> points_near(BallPixels& pixels, const EquatorLine& line);

/// Weighted sums of the residuals across a line, where f is about so steep: of a tilted line it is steeper
/// the nearer to the outline, and the photograph's blur counts for more.
struct LineProfile {
  static constexpr int kBins = 81;
  static constexpr std::array kSteepness{1.0, 1.4, 2.0, 2.8};
  struct Sums {
    std::array<double, kBins> sum{};
    std::array<double, kBins> weight{};
  };
  std::array<Sums, kSteepness.size()> of_steepness{};

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
    std::array<std::array<double, LineProfile::kBins>, LineProfile::kSteepness.size()> darkness{};
  };
  std::vector<Trial> trials_;
};

}  // namespace strobe::digitize
