// The image of one ball on a grid of pixels, by how far each pixel is covered.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/rig/camera.hpp"

namespace strobe::sim {

/// A smeared image is the mean of balls so far apart, and of at most so many.
inline constexpr double kSpacing_px = 0.25;
inline constexpr int kMaxInstants = 64;

/// A row's coverage by spans, as differences along it; x = 0 is the left side of the row's first pixel. Not
/// thread-safe; keeps its buffer.
class RowCoverage {
 public:
  void clear(std::size_t width) {
    differences_.assign(width + 2, 0.0);
    rises_ = falls_ = {width + 2, 0};
  }
  void add(double from, double to, double weight) {
    if (to <= from) return;
    note(from, weight, rises_);
    note(to, -weight, falls_);
  }
  bool empty() const { return first() >= end(); }
  /// Pixels from the first that a span begins in to behind the last that one ends in.
  std::size_t first() const { return std::min(rises_.first, falls_.first); }
  std::size_t end() const { return std::max(rises_.end, falls_.end); }
  /// Where coverage is even: all spans have begun, none has ended.
  std::size_t even_first() const { return rises_.end; }
  std::size_t even_end() const { return falls_.first; }
  double step(std::size_t pixel) const { return differences_[pixel]; }

 private:
  struct Range {
    std::size_t first = 0;
    std::size_t end = 0;
  };

  void note(double x, double weight, Range& range) {
    const double pixel = std::floor(x);
    const auto i = static_cast<std::size_t>(pixel);
    differences_[i] += weight * (pixel + 1.0 - x);
    differences_[i + 1] += weight * (x - pixel);
    range.first = std::min(range.first, i);
    range.end = std::max(range.end, i + 2);
  }

  std::vector<double> differences_;  ///< two more than the row is wide
  Range rises_;
  Range falls_;
};

// The image of one ball on a grid of pixels, and what a program measures on it: the camera's resolution as
// an effect of its own. Thread-safe per object; the buffers of a PixelGrid grow to the largest image and
// stay.
//
// What is drawn: on black, the ball's ellipse in even brightness kBall, and on it the equator as a dark bar
// through the centre (0.6 of the half diameter to either side, 6 % of the diameter wide). A pixel holds the
// mean brightness over its square, rounded to 8 bits. Each pixel row is cut into kLines lines, along which
// the ellipse's and the bar's ends are exact; across them the mean is the midpoint rule's. A ball that moves
// during the flash is drawn as the mean of balls spread evenly over its way, no more than a quarter pixel
// apart (at most 64). A ball that is pressed flat is drawn round. The equator is drawn
// straight, however its plane is tilted: pixels show no tilts.
//
// What is measured: M0, M1 the sums of w and w·(x, y) over the pixels, w the brightness over kBall but 1
// within 0.8 of the half diameter, where the bar is: centre M1/M0, diameter 2·sqrt(M0/pi), the equator's
// angle the main axis of the second moments of the darkness within 0.8 of the half diameter.
//
// How far off this can be, for a half diameter of r pixels. Rounding: at most 1/(2·kBall) in each w of at
// most 8·r + 8 pixels that the outline crosses, no farther than r + 2 from the centre. Lines: where the
// outline lies flat, its ends grow as sqrt(2·r·y) and the midpoint rule misses at most
// .25·sqrt(2·r)/kLines^1.5 px² at top and bottom each. Over the area pi·r² that moves the centre by at most
//   error_px(r) = ((8·r + 8)/(2·kBall) + .5·sqrt(2·r)/kLines^1.5)·(r + 2)/(pi·r²)
// and the diameter by at most as much (its moment is the area, 2·r the lever): .007 px at r = 130. The test
// finds a fifth of that.
//   The angle. The bar's moment Suv is off by at most 1/320 of a pixel (rounding) at each of 3.5·r pixels of
// its outline, .3·r along on average and .06·r across: over Suu - Svv = .0171·r^4 that is .011/r rad. A long
// side that rises by one line (1/8 px) over the bar's length is drawn as one step, whose slope is 1.5 times
// as large: .05/r rad. Together at most .1/r.

/// How the ball moves on the photograph while it is lit, in all.
struct MotionBlur {
  double x_px = 0.0;
  double y_px = 0.0;
  double turn_rad = 0.0;
};

struct PixelMeasurement {
  reduction::PointPx centre_px;
  double diameter_px = 0.0;
  std::optional<double> equator_rad;  ///< modulo pi; absent where the ball is too small for a line
};

class PixelGrid {
 public:
  static constexpr int kBall = 220;
  static constexpr int kBar = 60;
  static constexpr int kLines = 8;
  /// Balls are drawn from and up to this diameter; others are left as they are.
  static constexpr double kSmallest_px = 4.0;
  static constexpr double kLargest_px = 4000.0;
  static constexpr double kSmallestWithLine_px = 12.0;

  /// Bound of the error of centre and diameter, see above. [px]
  static double error_px(double half_diameter_px);

  /// `view` is the ball in the middle of the flash.
  PixelMeasurement measure(const BallView& view, const MotionBlur& smear);

  /// The picture of the last measure(): rows from below, x from left.
  const std::vector<std::uint8_t>& picture() const { return pixels_; }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  void lay_out(const BallView& view, const MotionBlur& smear);
  void draw(const BallView& view, const MotionBlur& smear);
  void paint(std::uint8_t* row) const;
  PixelMeasurement read(double half_diameter_px) const;

  struct Moments {
    double sum = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;
  };
  Moments brightness() const;  ///< about the first pixel, without second moments
  Moments darkness(double x0, double y0, double reach) const;  ///< about x0, y0, within reach

  int left_ = 0;  ///< the first pixel's place on the photograph
  int bottom_ = 0;
  int width_ = 0;
  int height_ = 0;
  RowCoverage ball_;
  RowCoverage bar_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace strobe::sim
