// Digitizing by hand on a tablet: from an exposure to the points of a frame, with the operator's errors.
// Deterministic for (scene, seed, exposure). Thread-safe; allocates.
#pragma once

#include <cstdint>
#include <vector>

#include "common/reduction/frame.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

struct Digitized {
  reduction::Frame frame;  ///< times are all zero: a photograph shows none; shot_id is for the caller to set
  std::vector<int> image_pulse;       ///< for each image of the frame the pulse that made it
  std::vector<MonoTime> image_stamp;  ///< and the mean of the sensors' edges; kNoTime: they gave none
};

/// Where and how large a ball is seen: camera.hpp, and pixels.hpp where the scene's camera has pixels. Four
/// points of the surface; of each image of the ball its centre, its diameter (twice the distance from
/// the centre to a point of the edge, so 2·sqrt(2) times as noisy as a coordinate), the equator's angle
/// modulo pi (of a line that may be tilted that of the line through its two ends, and the tilt where the
/// scene has one measured; none where it is all on the outline), the top where the ball is visibly flattened,
/// and the leg as a person sees it. Faults image_unseen leave images out. Noise of zero leaves the frame's
/// standard deviations absent.
Digitized digitize(const Scene& scene, std::uint64_t seed, const Exposure& exposure);

/// The same without error: the frame states the scene's noise but has none.
Digitized digitize_perfectly(const Scene& scene, std::uint64_t seed, const Exposure& exposure);

/// Digitized::image_pulse alone, without measuring anything.
std::vector<int> image_pulses(const Scene& scene, const Exposure& exposure);

/// Standard deviation of a diameter over that of a coordinate.
inline constexpr double kDiameterNoiseRatio = 2.0 * std::numbers::sqrt2;

}  // namespace strobe::sim
