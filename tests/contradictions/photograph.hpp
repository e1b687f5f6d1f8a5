// A scene's photograph as it is digitized: images at the flashes' times, in pixels, with noise; and the truth of it.
// Pure functions of plain values: thread-safe; they allocate.
#pragma once

#include <string>
#include <vector>

#include "common/reduction/frame.hpp"
#include "common/reduction/readout.hpp"
#include "tests/contradictions/scene.hpp"

namespace strobe::contradictions {

/// What a perfect reduction reads, and what its verdict rests on.
struct Truth {
  reduction::Quantities value;
  bool mirrored = false;
  bool slid = false;
  /// What is missing of the change of vx that ends the slip at touchdown; not above 0 where the ball grips. [m/s]
  double missing_mps = 0.0;
  double alpha = 0.55, radius_m = 0.0325;
};

struct Photograph {
  reduction::Frame frame;
  std::vector<Leg> legs;  ///< of each image, in truth
  Truth truth;
};

Truth truth(const Scene& scene);

/// Flashes reach from the scene's number of images before touchdown to that after lift-off, as far as the field of
/// view and the flight towards (away from) the surface allow; two images a leg at least.
Photograph photograph(const Scene& scene, Random& random);

}  // namespace strobe::contradictions
