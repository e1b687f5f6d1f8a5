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
  double proof_sd = 0.0;  ///< see proof_sd()
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

/// Trouble is provable from here on: a test for just this trouble, with one false alarm in a thousand (3.3
/// sd), then overlooks one in twenty (1.7 sd more).
inline constexpr double kProof_sd = 5.0;

/// By how many of its standard deviations the quantity that this trouble shifts is shifted, at the noise that
/// the frame states, in a test that looks for nothing else. 0 where nothing in the frame contradicts: two
/// surface points, a wrong ball without a calibrated scale. Infinite for trouble that is not a contradiction
/// between measurements.
double proof_sd(Kind kind, const Scene& scene, const Photograph& photograph, const Disturbance& disturbance);

/// Whether what is wrong is one of fewer than four surface points, or of fewer than five images of a leg, so
/// that it cannot be singled out: then, and only then, no_redundancy tells of it.
bool among_few(Kind kind, const Photograph& photograph, const Disturbance& disturbance);

}  // namespace strobe::contradictions
