// Conditions of one shot: the scene's means with this shot's random deviations. Plain values, thread-safe.
#pragma once

#include <cstdint>

#include "common/impact/closed_form/rebound.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::sim {

struct ShotConditions {
  impact::Motion touchdown;
  impact::Coefficients coefficients;  ///< e and mu; with contact = "grip" also e_x and the offset
  double stiffness_ratio = 1.0;       ///< with contact = "ode", as the next
  double offset_share = 0.0;
  double dwell_s = 0.0;      ///< touchdown to lift-off, the ball's weight left out
  double equator_rad = 0.0;  ///< angle of the equator line at touchdown
  double lag_s = 0.0;        ///< trigger to touchdown
  double spot_m = 0.0;       ///< point of touchdown, along the surface from where the camera has its origin
  double off_plane_m = 0.0;  ///< of the ball's path from the plane the camera is focused on, towards the lens
};

/// Normal draws are within kLargestNormal standard deviations of their means.
ShotConditions draw_shot_conditions(const Scene& scene, std::uint64_t seed, int shot);

/// Of the same ball where it comes down once more: it is as elastic as its speed there makes it.
ShotConditions conditions_of_next_bounce(const Scene& scene, const ShotConditions& before,
                                         const impact::Motion& touchdown);

/// The scene without any spread of machine, bounce and plane: every shot is the mean one, but for the
/// equator's angle.
Scene without_spread(Scene scene);

}  // namespace strobe::sim
