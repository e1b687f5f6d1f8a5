// One shot with trouble of one kind, repeatable from its seed and number. Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <string>

#include "tests/contradictions/photograph.hpp"
#include "tests/contradictions/trouble.hpp"

namespace strobe::contradictions {

struct Shot {
  Kind kind = Kind::none;
  Photograph photograph;
  double severity =
      0.0;  ///< in the unit that the kind's words name; 0 where the draw left nothing to disturb
};

Shot drawn_shot(Kind kind, const Settings& settings, std::uint64_t seed, std::uint64_t number);

/// Changes what is true, or what is told of it, before the photograph is taken. Returns the severity.
double disturb_scene(Kind kind, Scene& scene, Random& random);

/// Changes what was measured. Returns the severity.
double disturb_measurements(Kind kind, const Scene& scene, Photograph& photograph, Random& random);

}  // namespace strobe::contradictions
