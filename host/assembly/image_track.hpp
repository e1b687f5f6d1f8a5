// From a frame to the path of the ball, seen from the surface. No I/O; thread-safe; cheap.
#pragma once

#include <optional>
#include <strobe_msgs/frame_t.hpp>

#include "common/reduction/matching/track.hpp"

namespace strobe::host {

/// A person who marks a centre by hand errs by about 0.5 mm in each coordinate, as a share of a ball's diameter.
inline constexpr double kHandSdOfDiameter = 0.008;

/// The images' centres in the surface's axes, with their scale, noise and legs. A leg that the frame names is
/// kept unless the centre is clearly less than a radius above the surface; the others are classified.
/// Returns nullopt without a surface line or a positive diameter, or if a coordinate is not finite.
std::optional<matching::Track> image_track(const strobe_msgs::frame_t& frame, double ball_diameter_m,
                                           double surface_angle_deg);

}  // namespace strobe::host
