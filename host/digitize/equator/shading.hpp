// One ball's image as a unit disc, and the equator line on it. Unit coordinates: u to the right and v up, in
// radii from the disc's middle, so that the outline is u² + v² = 1 even if perspective makes it an ellipse; z
// = sqrt(1 - u² - v²) points to the lens. Plain values; thread-safe; no allocation.
//
// A band on the sphere about a great circle whose plane is tilted by t out of the line of sight is where
// f = v'·cos(t) - z·sin(t) - offset is small, (u', v') being turned by the line's angle: half an ellipse of
// half axes 1 and sin(t), that begins and ends at the outline, on a diameter.
#pragma once

#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <span>
#include <utility>
#include <vector>

#include "host/digitize/core/plane_map.hpp"
#include "host/digitize/core/types.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

/// Darkness across a line, 0 to 1: a bar of `half_width`, blurred by a Gaussian of sd `soft`. Both in radii.
struct LineShape {
  double half_width = 0.05;
  double soft = 0.02;

  double darkness(double f) const;
  /// d(darkness)/df
  double derivative(double f) const;
  /// Sd of the darkness' distribution: the line's width, blur included.
  double spread() const { return std::sqrt(half_width * half_width / 3.0 + soft * soft); }
  /// The darkness is negligible beyond this |f|.
  double reach() const { return half_width + 3.0 * soft; }
};

/// Tabulated darkness of a shape and its derivative.
class ShapeTable {
 public:
  explicit ShapeTable(const LineShape& shape);
  double reach() const { return reach_; }
  /// Darkness and its derivative.
  std::pair<double, double> at(double f) const {
    const double place = std::abs(f) * per_radius_;
    if (!(place < kSteps)) return {0.0, 0.0};
    const auto k = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(k);
    const double dark = dark_[k] + part * (dark_[k + 1] - dark_[k]);
    const double derivative = derivative_[k] + part * (derivative_[k + 1] - derivative_[k]);
    return {dark, f < 0.0 ? -derivative : derivative};
  }

 private:
  static constexpr int kSteps = 64;
  double reach_;
  double per_radius_;  ///< steps
  std::array<double, kSteps + 1> dark_{};
  std::array<double, kSteps + 1> derivative_{};
};

/// An equator line in unit coordinates.
struct EquatorLine {
  double angle_rad = 0.0;
  double tilt_rad = 0.0;
  double offset = 0.0;    ///< of its plane from the ball's middle, radii
  double contrast = 0.0;  ///< share of the brightness that its middle takes
  LineShape shape;
};

/// Between the directions of two lines, 0 to pi/2; less for those tilted so far that their ends tell little.
inline double angle_between(const EquatorLine& a, const EquatorLine& b) {
  return std::abs(std::remainder(a.angle_rad - b.angle_rad, CV_PI)) *
         std::cos(std::max(std::abs(a.tilt_rad), std::abs(b.tilt_rad)));
}

/// Coordinates of points along and across a line.
class LineCoordinates {
 public:
  explicit LineCoordinates(const EquatorLine& line)
      : cos_(std::cos(line.angle_rad)),
        sin_(std::sin(line.angle_rad)),
        cos_tilt_(std::cos(line.tilt_rad)),
        sin_tilt_(std::sin(line.tilt_rad)),
        offset_(line.offset) {}

  double along(double u, double v) const { return cos_ * u + sin_ * v; }
  double across(double u, double v) const {
    return across(u, v, std::sqrt(std::max(0.0, 1.0 - u * u - v * v)));
  }
  double across(double u, double v, double z) const {
    return (cos_ * v - sin_ * u) * cos_tilt_ - z * sin_tilt_ - offset_;
  }
  /// Of across().
  cv::Point2d gradient(double u, double v, double z) const {
    const double turn = sin_tilt_ / z;
    return {-sin_ * cos_tilt_ + u * turn, cos_ * cos_tilt_ + v * turn};
  }
  double sin_tilt() const { return sin_tilt_; }

 private:
  double cos_, sin_, cos_tilt_, sin_tilt_, offset_;
};

/// Radii of a disc that a line is sought in: nearer to the outline the felt's fuzz and the steep shading hide
/// it.
inline constexpr double kInner = 0.95;

struct Disc {
  cv::Point2d centre_image;
  cv::Matx22d unit_from_image;
  cv::Matx22d image_from_unit;
  cv::Matx22d plane_from_unit;
  double radius_image_px = 0.0;
  double rim = 0.0;        ///< half width of the ring around the outline that its edge disturbs, radii
  double blur = 0.0;       ///< sd of its edge's blur, radii
  double centre_sd = 0.0;  ///< radii
  double radius_sd = 0.0;  ///< radii

  cv::Point2d unit(double column, double row) const {
    const double x = column - centre_image.x, y = row - centre_image.y;
    return {unit_from_image(0, 0) * x + unit_from_image(0, 1) * y,
            unit_from_image(1, 0) * x + unit_from_image(1, 1) * y};
  }
  /// Half the width and height of a disc of that many radii on the photograph.
  cv::Point2d half_extent_px(double radii) const;
};

/// Lens distortion and perspective are linearized over the ball.
Disc make_disc(const PlaneMap& map, const Outline& outline);
/// Whether all is finite and the radius is at least a pixel.
bool is_valid(const Disc& disc);

/// Share of a line's length where other balls' light falls off towards their limbs, a fifth of a radius
/// inside them, and is the least known. `others`: of `discs`.
double beside_limbs(const EquatorLine& line, const Disc& disc, std::span<const Disc> discs,
                    std::span<const std::size_t> others);

// Shading of the balls' images. Exposure adds up: intensity is the background plus the shadings of all balls
// that overlap there. Each ball's is a low-order function of its disc; all are fitted together. Deterministic
// for any number of threads; thread-safe; allocates.

/// A part of the photograph, binned by stride x stride pixels.
struct BinnedImage {
  int stride = 1;
  cv::Point origin;   ///< image px of the first bin's first pixel
  cv::Mat intensity;  ///< CV_32FC1, mean of each bin
  float saturation = 1.0F;

  /// Image px of a bin's middle.
  double column(double i) const { return origin.x + stride * (i + 0.5) - 0.5; }
  double row(double j) const { return origin.y + stride * (j + 0.5) - 0.5; }
  /// The bins whose middles are within that many radii of the disc; empty outside of the part.
  cv::Rect around(const Disc& disc, double radii) const;
};

/// The part around all discs.
BinnedImage bin_image(const Photograph& photograph, std::span<const Disc> discs, int stride);

/// A ball's brightness over its disc, p(u, v) + z·q(u, v) with p of third and q of second order: all
/// polynomials of third order on the sphere, which represent Lambert shading by any lamps within some per
/// cent (Ramamoorthi and Hanrahan 2001); and the background around it.
struct Shading {
  static constexpr int kTerms = 16;
  std::array<float, kTerms> terms{};
  float background = 0.0F;

  static void basis(float u, float v, float z, float* terms);
  float at(float u, float v, float z) const {
    const auto& t = terms;
    const float p = t[0] + u * (t[1] + u * (t[3] + u * t[6])) +
                    v * (t[2] + u * (t[4] + u * t[7]) + v * (t[5] + u * t[8] + v * t[9]));
    const float q = t[10] + u * (t[11] + u * t[13]) + v * (t[12] + u * t[14] + v * t[15]);
    return p + z * q;
  }
  /// Of at().
  cv::Point2f gradient(float u, float v, float z) const {
    const auto& t = terms;
    const float q = t[10] + u * (t[11] + u * t[13]) + v * (t[12] + u * t[14] + v * t[15]);
    const float along_u =
        t[1] + u * (2.0F * t[3] + 3.0F * u * t[6]) + v * (t[4] + 2.0F * u * t[7] + v * t[8]);
    const float along_v =
        t[2] + v * (2.0F * t[5] + 3.0F * v * t[9]) + u * (t[4] + u * t[7] + 2.0F * v * t[8]);
    return {along_u + z * (t[11] + 2.0F * u * t[13] + v * t[14]) - u / z * q,
            along_v + z * (t[12] + u * t[14] + 2.0F * v * t[15]) - v / z * q};
  }
};

/// Robust fit, so that lines and print count little. One for each disc, in their order. `across`: samples
/// over a disc's diameter, at most one for each bin.
std::vector<Shading> fit_shadings(const BinnedImage& image, std::span<const Disc> discs, int across);

}  // namespace strobe::digitize
