// Photographs that are crowded, curved or of an unusual scale: many images, deep overlaps, a ball that rolls, several
// bounces, a second ball. Each changes a scene's shot so that the photograph holds what is asked for; the truth follows
// from the scene. Deterministic; thread-safe; `bounces` reads a shipped scene.
#pragma once

#include "tests/studies/digitize/photographs.hpp"

namespace strobe::studies::digitize {

/// The camera farther away or nearer: the ball's diameter in px.
void set_size(Take& take, double diameter_px);

/// About so many images of the mean ball, .8 diameters apart before the bounce: as wide a view as that takes, on a
/// photograph of at most 5 megapixels.
void set_images(Take& take, double images);

/// Steps of so many diameters before the bounce, with as much less light as images lie over one another.
void set_overlap(Take& take, double step_of_diameter);

/// A slow throw onto a surface that gives this share of the speed back: of hardly any, the ball rolls on. In a view
/// of twelve diameters, .8 of one apart.
void set_rolling(Take& take, double restitution);

/// A ball that rolls in along the surface and on, its centre this many mm above where it would touch, at the border.
void set_skimming(Take& take, double height_mm);

/// Bounces in view of a slow ball, with a flash every 40 ms, 2 to 4.
void set_bounces(Take& take, double bounces);

/// A second ball alike, this many ms after the first; 0: none.
void set_second_ball(Take& take, double later_ms);

/// A second ball that lies on the plate, so many diameters to the right of the touchdown; 0: none. Of the
/// independent renderer only.
void set_ball_at_rest(Take& take, double at_diameters);

}  // namespace strobe::studies::digitize
