// Flattens a photograph under the balls' images: exposure adds up, so that what is seen is the background and
// the sum of the shadings of all balls that lie there. Each ball's own is a low-order function of its disc,
// fitted to all of them together; what is left is what is drawn on the balls. Deterministic for any number of
// threads; thread-safe; allocates.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "host/digitize/equator_disc.hpp"
#include "host/digitize/photograph.hpp"

namespace strobe::digitize {

/// A part of the photograph in blocks of stride x stride pixels.
struct Blocks {
  int stride = 1;
  cv::Point origin;  ///< image px of the first block's first pixel
  cv::Mat light;     ///< CV_32F, mean of each block
  float saturation = 1.0F;

  double column(double i) const { return origin.x + stride * (i + 0.5) - 0.5; }
  double row(double j) const { return origin.y + stride * (j + 0.5) - 0.5; }
  /// Blocks whose middles are within the disc of `radii`; empty outside of the part.
  cv::Rect around(const Disc& disc, double radii) const;
};

/// The part that holds all discs.
Blocks cut_blocks(const Photograph& photograph, std::span<const Disc> discs, int stride);

/// A ball's brightness over its disc: polynomials of u, v and z to the third order, which hold any Lambert
/// lamps' light to some per cent (Ramamoorthi and Hanrahan 2001), and the background about it.
struct Shading {
  static constexpr int kTerms = 16;
  std::array<float, kTerms> terms{};
  float background = 0.0F;

  static void basis(float u, float v, float z, float* terms);
  float at(float u, float v, float z) const;
};

/// Fitted to the blocks robustly, so that lines and print count little. One for each disc, in their order.
std::vector<Shading> fit_shadings(const Blocks& blocks, std::span<const Disc> discs);

/// What is left of the light when background and shadings are taken away.
struct Flattened {
  cv::Mat left;   ///< CV_32F
  cv::Mat noise;  ///< CV_32F: sum of the squares of the shadings there, as felt's grain adds up; negative: no
                  ///< use (saturated, in the ring about an outline, in no disc)
};

Flattened flatten(const Blocks& blocks, std::span<const Disc> discs, std::span<const Shading> shadings);

/// Changes the light as a line on a ball does (sign 1), or undoes that (-1).
void add_line(const Blocks& blocks, const Disc& disc, const Shading& shading, const DiscLine& line,
              float sign, cv::Mat& left);

}  // namespace strobe::digitize
