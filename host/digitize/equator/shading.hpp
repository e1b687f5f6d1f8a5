// Shading of the balls' images. Exposure adds up: intensity is the background plus the shadings of all balls
// that overlap there. Each ball's is a low-order function of its disc; all are fitted together. Deterministic
// for any number of threads; thread-safe; allocates.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "host/digitize/equator/disc.hpp"
#include "host/digitize/image/photograph.hpp"

namespace strobe::digitize {

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
};

/// Robust fit, so that lines and print count little. One for each disc, in their order. `across`: samples
/// over a disc's diameter, at most one for each bin.
std::vector<Shading> fit_shadings(const BinnedImage& image, std::span<const Disc> discs, int across);

}  // namespace strobe::digitize
