// Rendered photographs under drawn conditions, and how far the digitizer is off on each image of them.
// Deterministic; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/result.hpp"
#include "host/design/digitizer_noise.hpp"
#include "sim/scene/scene.hpp"
#include "tests/studies/digitize/photographs.hpp"

namespace strobe::studies::design {

/// What is drawn for a photograph; the rest of its look is drawn by the simulator.
struct NoiseCondition {
  double diameter_px = 0.0;
  double blur_px = 0.0;
  double motion_px = 0.0;  ///< before the impact
  double exposure = 0.0;
  double full_well_e = 0.0;
  double read_noise_e = 0.0;
  int bits = 8;
  double line_contrast = 0.0;
  double step = 0.0;  ///< between images, over the diameter; before the impact
  double period_s = 0.0;
  double speed_mps = 0.0;
  double angle_rad = 0.0;
  double spin_radps = 0.0;
  int images = 0;  ///< of a leg, at most
};

NoiseCondition draw_condition(std::uint64_t seed, int number);

/// A whole image in the air, and by how much it was measured wrong.
struct NoiseSample {
  host::PictureConditions picture;
  bool rebound = false;
  bool found = false;
  double along_px = 0.0, across_px = 0.0;  ///< of the centre, to the ball's path
  double lowest_px = 0.0;                  ///< of its lowest point's height
  double centre_sd_px = 0.0;               ///< as stated, each coordinate
  double diameter_px = 0.0, diameter_sd_px = 0.0;
  std::optional<double> equator_rad{};
  double equator_sd_rad = 0.0;
};

struct NoisePhotograph {
  int number = 0;
  NoiseCondition condition;
  std::vector<NoiseSample> images;
  int invented = 0;
  std::optional<double> surface_px;  ///< of its line's height in the middle; absent: not found
  double surface_sd_px = 0.0;        ///< as stated, of a point
};

/// The `number`-th photograph (1-based) of that seed, `each` of the same condition.
Result<NoisePhotograph> noise_photograph(std::uint64_t seed, int number, int each);

}  // namespace strobe::studies::design
