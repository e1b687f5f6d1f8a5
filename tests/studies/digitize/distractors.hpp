// What is no ball, on a photograph: round things, a textured background, and the dim discs that a room's
// light draws between flashes. It is added to either renderer's photograph, so that false and doubtful images
// occur at all.
// Deterministic; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <span>

#include "host/digitize/image/photograph.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

/// Light is told over that of the ball's lightest part.
struct Distractors {
  int round_things = 0;  ///< discs, lit spheres, rings and arcs of about the ball's size
  double texture = 0.0;  ///< sd of the background's light, from a twentieth of the ball's size to twice that
  double trail = 0.0;    ///< light of two discs between one flash and the next

  bool any() const { return round_things > 0 || texture > 0.0 || trail > 0.0; }
};

/// `ball_light`: of the lightest part of one image. `truth`: in order of time.
void add_distractors(const Distractors& distractors, std::uint64_t seed, double ball_light,
                     std::span<const TrueImage> truth, strobe::digitize::Photograph& photograph);

}  // namespace strobe::studies::digitize
