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
  double proof_sd = 0.0;  ///< see proof.hpp
  bool few = false;       ///< likewise
};

Shot drawn_shot(Kind kind, const Settings& settings, std::uint64_t seed, std::uint64_t number);

/// Changes what is true, or what is told of it, before the photograph is taken. Returns the severity.
double disturb_scene(Kind kind, Scene& scene, Random& random);

struct Disturbance {
  double severity = 0.0;
  std::size_t index = 0;  ///< of the surface point or image, one of them where there were several
};

/// Changes what was measured.
Disturbance disturb_measurements(Kind kind, const Scene& scene, Photograph& photograph, Random& random);

}  // namespace strobe::contradictions
