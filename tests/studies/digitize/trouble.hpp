// What is no ball, on a photograph: round things, a textured background, and the dim discs that a room's light draws
// between flashes. It is added to either renderer's photograph, so that false and doubtful images occur at all.
// Deterministic; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/digitize/image/photograph.hpp"
#include "tests/studies/digitize/score.hpp"

namespace strobe::studies::digitize {

/// Light is told over that of the ball's lightest part.
struct Trouble {
  int round_things = 0;  ///< discs, lit spheres, rings and arcs of about the ball's size
  double texture = 0.0;  ///< sd of the background's light, from a twentieth of the ball's size to twice that
  double trail = 0.0;    ///< light of two discs between one flash and the next

  bool any() const { return round_things > 0 || texture > 0.0 || trail > 0.0; }
};

/// `ball_light`: of the lightest part of one image. `truth`: in order of time.
void add_trouble(const Trouble& trouble, std::uint64_t seed, double ball_light, std::span<const TrueImage> truth,
                 strobe::digitize::Photograph& photograph);

/// A reliability diagram in words: what was stated of images, and of how many it is true.
class Reliability {
 public:
  enum class Is { ball, other_ball, none };
  void add(double probability, Is what);
  void add(const Reliability& other);
  /// By classes of probability: images, balls' and second balls' among them, the balls' share with its 95 %
  /// interval after Wilson, J. Am. Stat. Assoc. 22 (1927), and the mean of what was stated.
  void print() const;

 private:
  struct Class {
    int images = 0, balls = 0, others = 0;
    double stated = 0.0;
  };
  std::vector<Class> classes_;
};

}  // namespace strobe::studies::digitize
