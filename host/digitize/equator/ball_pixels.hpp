// One ball's blocks of a photograph, row by row, with all that is known of other light taken away: what is
// left is what is drawn on the ball. Each thread needs a reader of its own; allocates when made.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/digitize/equator/shading.hpp"

namespace strobe::digitize {

/// Another ball whose disc overlaps, with its line if that is known and to be taken away.
struct Neighbour {
  std::size_t ball = 0;
  std::optional<EquatorLine> line;
};

class BallPixels {
 public:
  /// A block under the ball.
  struct Block {
    float u = 0.0F, v = 0.0F, z = 0.0F;
    float left = 0.0F;   ///< of the light, less background and shadings
    float own = 0.0F;    ///< the ball's shading
    float noise = 0.0F;  ///< sum of the squares of the shadings there, as felt's grain adds up
    bool full = false;   ///< saturated
    bool use = false;    ///< not saturated, nor in the ring about an outline
  };

  BallPixels(const BinnedImage& blocks, std::span<const Disc> discs, std::span<const Shading> shadings,
             std::size_t ball, std::span<const Neighbour> neighbours);

  const Disc& disc() const { return *disc_; }
  const Shading& shading() const { return *shading_; }
  int stride() const { return blocks_->stride; }
  /// Least light at which the ball can be told anything of.
  float floor() const { return floor_; }

  /// Rows that hold blocks of the disc of `radii`.
  cv::Range rows(double radii) const;
  /// The blocks of a row within `radii`, and, if `band` is given, within that distance of a line through the
  /// middle in its direction.
  struct Band {
    double angle_rad = 0.0;
    double within = 1.0;  ///< radii
  };
  std::span<const Block> row(int j, double radii, const std::optional<Band>& band = {});

 private:
  struct Other {
    const Disc* disc;
    const Shading* shading;
    std::optional<LineCoordinates> place;
    std::optional<ShapeTable> shape;
    double contrast = 0.0;
  };
  void subtract(const Other& other, int j, int from);

  const BinnedImage* blocks_;
  const Disc* disc_;
  const Shading* shading_;
  float floor_;
  std::vector<Other> others_;
  std::vector<Block> row_;
  std::vector<float> background_;
  std::vector<float> count_;
};

}  // namespace strobe::digitize
