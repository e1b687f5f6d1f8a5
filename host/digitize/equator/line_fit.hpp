// From a rough line to its angle: the line is cut into segments, each says how far it is off to the side,
// and a straight line (or half an ellipse) is fitted to them robustly. What seams, print and neighbours do to
// some segments is then an outlier, and how the rest scatters is the standard deviation, whatever the felt.
// Thread-safe; allocates.
#pragma once

#include <optional>
#include <vector>

#include "host/digitize/equator/ball_pixels.hpp"

namespace strobe::digitize {

/// One stretch of the line.
struct Segment {
  double along = 0.0;          ///< u' of its middle, radii
  double off = 0.0;            ///< to the side of the fitted line, radii
  double weight = 0.0;         ///< inverse variance of `off` but for a factor common to all
  double dark = 0.0;           ///< contrast
  double dark_sd = 0.0;        ///< but for the same factor's root
  double inlier_weight = 1.0;  ///< 1 what fits, to 0 an outlier
};

struct LineFit {
  EquatorLine line;
  std::vector<Segment> segments;
  double per_variance = 0.0;    ///< variance of the angle for a scatter of one, rad²
  double scatter = 0.0;         ///< variance of the segments' offs times weight, that of M-estimation
  double inside_scatter = 0.0;  ///< the same as expected of what is within each stretch
  double freedom = 0.0;         ///< degrees of it
  double neighbours = 0.0;      ///< sum of the products of next segments' offs, as `scatter`
  double dark_share = 0.0;      ///< of the segments that could tell, those that are dark
  double contrast_significance =
      0.0;                    ///< how many sd the line is dark, by how the segments' darkness differs
  double inlier_share = 0.0;  ///< of the segments, by weight, that fit
  double rms_offset = 0.0;    ///< rms of all segments' offs, radii
  double span = 0.0;          ///< between the outermost segments, radii, at most 1.9
};

class ShapeGrid;

struct LineFitSettings {
  double offset_sd = 0.01;  ///< how far the line's middle may be from the disc's, radii
  double tilt_sd = 0.15;
  const ShapeGrid* shapes = nullptr;  ///< without, the start's shape is kept
};

/// A block near a line: brightness relative to the ball's own.
struct LinePoint {
  float u = 0.0F, v = 0.0F, z = 0.0F;
  float x = 0.0F;
  float weight = 0.0F;
};

std::vector<LinePoint> points_near(BallPixels& rows, const EquatorLine& line);

/// Weighted means of the brightness across a line.
struct LineProfile {
  static constexpr int kBins = 81;
  std::array<double, kBins> sum{};
  std::array<double, kBins> weight{};

  void add(std::span<const LinePoint> points, const EquatorLine& line);
  void add(const LineProfile& other);
};

/// Shapes that a line may have, to be tried on profiles.
class ShapeGrid {
 public:
  /// `radius`: the ball's in blocks, which do not show anything sharper than they are.
  explicit ShapeGrid(double radius);
  /// The shape of least squares.
  LineShape best(const LineProfile& profile) const;

 private:
  struct Trial {
    LineShape shape;
    std::array<double, LineProfile::kBins> darkness{};
  };
  std::vector<Trial> trials_;
};

/// `radius`: the ball's in blocks. Absent: too little is seen to fit anything.
std::optional<LineFit> fit_line(std::span<const LinePoint> points, double radius, const EquatorLine& start,
                                const LineFitSettings& settings);

}  // namespace strobe::digitize
