// Which images show the ball in the air before the impact, in contact, and in the air after it. Asked twice,
// since more is known the second time: before images are matched to flashes only order and place decide; once
// they have times, when the other images of a leg touch the surface. What digitized the photograph may have
// said so already: its labels are kept unless the ball touches. Pure functions; thread-safe; they allocate.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "common/shot/leg.hpp"

namespace strobe::geometry {

/// One image whose flash is known.
struct TimedHeight {
  double time_s = 0.0;
  double height_m = 0.0;               ///< of the ball's lower edge above the surface line
  double variance_m2 = 0.0;            ///< of the centre's height
  std::optional<Leg> leg;              ///< as labelled
  double reference_variance_m2 = 0.0;  ///< of the surface's height beneath it and the ball's radius together
};

struct LegAssignment {
  std::vector<Leg> legs;  ///< one per image
  std::vector<std::size_t>
      overlaps;  ///< images labelled airborne that are in contact; their leg is `contact`
};

/// Legs of images with times, in order of time. Labels are kept, except of airborne images that come after
/// the touchdown (before the lift-off) which the other images of their leg predict. An image near the surface
/// is judged by the predicted time of touchdown or lift-off, never by its own noisy height: choosing by
/// height would keep the images whose error points up and make the stated errors too small. Only one that
/// lies three sd beneath touching is in contact whatever the prediction, which leaves out the air.
LegAssignment classify_timed(std::span<const TimedHeight> images, double gravity_y_mps2);

/// Legs of images whose flashes are not yet known, in order of time; centres in the surface's axes, y up.
/// Labels are kept, except that a centre below `contact_height` is in contact. Without a label an image
/// belongs to the incoming leg before the lowest image and to the rebound after it. Images out of order (a
/// rebound before an incoming one) become contact images, so that the legs follow each other.
std::vector<Leg> classify_untimed(std::span<const Eigen::Vector2d> centres,
                                  std::span<const std::optional<Leg>> labels, double contact_height);

}  // namespace strobe::geometry
