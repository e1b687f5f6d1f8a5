// Bounces over which impact models are judged. Deterministic from the seed; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/impact/ode/contact_ode.hpp"

namespace strobe::studies::trade {

struct ImpactScene {
  std::string name;
  ball::Ball ball;
  impact::Motion touchdown;
  impact::ContactCoefficients contact;

  double speed_mps() const;  ///< of the centre at touchdown
};

inline constexpr const char* kPracticalRange =
    "1 to 60 m/s, 5 to 85 degrees, |R omega| up to the speed and 600 rad/s, e .5-.9, mu .3-.9, dwell 3-6.5 "
    "ms, "
    "balls of the rules, tangential spring .7-2.5 of the normal one, its damping .2-1.5, offset 0-.25";

/// Of kPracticalRange, drawn independently; the speed evenly in its logarithm.
std::vector<ImpactScene> practical_impacts(int count, std::uint64_t seed);

/// The thesis's 21 conditions: touchdown, e and dwell time as measured, the rest as fitted to them.
std::vector<ImpactScene> thesis_impacts();

/// Shots of one scene: touchdown and material spread about the scene's as a pitching machine and a surface
/// do (speed 2 %, angle 0.6 degree, spin 10 rad/s, e .01, mu .03, dwell 1.5 %).
std::vector<ImpactScene> shots_of(const ImpactScene& scene, int count, std::uint64_t seed);

}  // namespace strobe::studies::trade
