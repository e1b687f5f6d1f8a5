// Rendered photographs of simulated shots as the digitizer and the score need them. Deterministic;
// thread-safe; allocates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.hpp"
#include "host/digitize/digitize.hpp"
#include "host/digitize/photograph.hpp"
#include "sim/rig/scene.hpp"
#include "tests/bench/digitize/score.hpp"

namespace strobe::bench::digitize {

struct KnownPhotograph {
  strobe::digitize::Photograph photograph;  ///< read as from a file
  strobe::digitize::DigitizeSettings settings;
  std::vector<TrueImage> truth;
  std::vector<double> times_s;  ///< of the true images, in the same order
  double decode_ms = 0.0;
};

/// Of the scene's `shot`-th shot (1-based). Fails as Shooter, render() and decode_photograph() do.
Result<KnownPhotograph> known_photograph(const sim::Scene& scene, std::uint64_t seed, int shot);

}  // namespace strobe::bench::digitize
