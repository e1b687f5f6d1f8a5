// From a frame to the path of the ball, seen from the surface. No I/O; thread-safe; cheap.
#pragma once

#include <optional>
#include <strobe_msgs/frame_t.hpp>

#include "host/assembly/track.hpp"

namespace strobe::host {

/// Levels the photograph, finds the scale and says which images were in the air. A leg that the frame names
/// is kept unless the centre lies clearly less than a radius above the surface; a leg that it leaves open is
/// found. Nothing if there is no surface line, no positive diameter, or a coordinate that is not finite.
std::optional<Track> image_track(const strobe_msgs::frame_t& frame, double ball_diameter_m,
                                 double surface_angle_deg);

}  // namespace strobe::host
