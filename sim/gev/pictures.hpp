// What the simulated camera's sensor gives. Deterministic; thread-safe; allocates; uses OpenCV's threads.
#pragma once

#include "common/result.hpp"
#include "sim/gev/device.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim::gev {

/// As the camera's registers say.
struct PictureSettings {
  PixelFormat format = PixelFormat::mono8;
  double exposure_s = 0.01;  ///< of a timed exposure
  double gain_db = 0.0;
  double black_level_dn = 0.0;  ///< of 12 bits
  double gamma = 1.0;           ///< 1: off
  bool operator==(const PictureSettings&) const = default;
};
PictureSettings picture_settings(const Device& device);

/// The rig's exposure, developed for the wire: rows from the top, numbers of 16 bits low byte first. A Bayer
/// mosaic is that of a grey scene under white light. Fails for a sensor that is too large.
Result<Packet> shot_pixels(const Scene& scene, std::uint64_t seed, const Exposure& exposure,
                           const PictureSettings& settings);

/// Without the rig: the scene in the light of the room, with a ball that somebody holds into the view. It is
/// as light as a photograph of the rig at an exposure of 10 ms.
Result<Packet> room_pixels(const Scene& scene, std::uint64_t seed, const PictureSettings& settings);

}  // namespace strobe::sim::gev
