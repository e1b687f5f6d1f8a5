// Which images show the ball in the air before the impact, in contact, and in the air after it.
// Part of the reduction, not of its interface. Pure functions; thread-safe.
#pragma once

#include <optional>
#include <vector>

#include "common/reduction/frame.hpp"

namespace strobe::reduction {

/// One image as the leg finder sees it.
struct Height {
  double time_s = 0.0;
  double height_m = 0.0;     ///< of the ball's lower edge above the surface line
  double variance_m2 = 0.0;  ///< of the centre's height
  std::optional<Leg> leg;    ///< as labelled
};

struct LegAssignment {
  std::vector<Leg> legs;  ///< one per image
  /// Images labelled airborne that are in contact; their leg is `contact`.
  std::vector<std::size_t> overlaps;
};

/// Labels are kept, but for airborne images whose leg touches the surface before them; images without a label
/// are assigned. An image near the surface is judged by the time at which its leg, predicted from the leg's
/// other images, touches down or lifts off, never by its own noisy height: choosing by height would keep the
/// images whose error points up, and the stated errors would be untrue. reference_variance_m2 is that of the
/// surface's height and the ball's radius together.
LegAssignment classify_legs(const std::vector<Height>& images, double gravity_y_mps2,
                            double reference_variance_m2);

}  // namespace strobe::reduction
