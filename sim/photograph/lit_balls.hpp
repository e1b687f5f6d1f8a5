// The balls lit by an exposure's flashes, if any part of them is on the sensor: both the rendering and the
// truth use them. Thread-safe; allocates.
#pragma once

#include <array>
#include <vector>

#include "sim/photograph/appearance.hpp"
#include "sim/photograph/optics.hpp"
#include "sim/rig/exposure.hpp"

namespace strobe::sim {

/// One ball at one instant. A ball in contact is a sphere whose top is lowered by top_drop_m, cut off by the
/// surface.
struct LitBall {
  Vec3 centre;             ///< of the sphere, axis coordinates
  double angle_rad = 0.0;  ///< of its line, counter-clockwise in axis coordinates, at the middle of the view
  std::array<double, 2> light{};  ///< of each lamp, over that of a usual flash
};

struct BallImageOnSensor {
  FilmImage film;
  LitBall middle;              ///< in the middle of the flash
  std::vector<LitBall> balls;  ///< spread over the flash where the ball moves visibly; at least one
};

/// Of the balls that a fault throws besides the shot's.
std::vector<BallImageOnSensor> more_lit_balls(const Scene& scene, const Exposure& exposure,
                                              const Appearance& appearance);

/// In order of time.
std::vector<BallImageOnSensor> lit_balls(const Scene& scene, const Exposure& exposure,
                                         const Appearance& appearance);

/// Light of each lamp in all flashes of the exposure while the shutter was open.
std::array<double, 2> light_of_all(const Exposure& exposure, const Appearance& appearance, double power_sd);

/// The outline of a ball as seen on the photograph, lens included: points around it, counter-clockwise. Not
/// cut off by the surface.
std::vector<Vec2> outline_on_sensor(const Optics& optics, const Vec3& centre, double radius_m, int points);

}  // namespace strobe::sim
