#include "tests/contradictions/shot.hpp"

#include <algorithm>

#include "tests/contradictions/proof.hpp"

namespace strobe::contradictions {

Shot drawn_shot(Kind kind, const Settings& settings, std::uint64_t seed, std::uint64_t number) {
  Random random(seed, static_cast<std::uint64_t>(kind), number);
  Scene scene = drawn_scene(settings, random);
  Shot shot;
  shot.kind = kind;
  const double before = disturb_scene(kind, scene, random);
  shot.photograph = photograph(scene, random);
  shot.photograph.frame.shot_id = static_cast<int>(number % 1'000'000'000U);
  const Disturbance after = disturb_measurements(kind, scene, shot.photograph, random);
  shot.severity = std::max(before, after.severity);
  const Disturbance whole{shot.severity, after.index};
  shot.proof_sd = proof_sd(kind, scene, shot.photograph, whole);
  shot.few = among_few(kind, shot.photograph, whole);
  return shot;
}

}  // namespace strobe::contradictions
