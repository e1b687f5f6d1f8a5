// What the tests of the fits share: random numbers whose seed is printed, measurements made from a truth that
// was computed independently of the models under test.
#pragma once

#include <rapidcheck.h>

#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "common/impact/fit/rebound_model.hpp"
#include "tests/common/impact_fit/impulse_balance.hpp"
#include "tests/common/physics/thesis_folder.hpp"

namespace strobe::testing {

/// For rapidcheck; ends and middle come up often.
inline double real(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1'000'001) / 1e6;
}

/// STROBE_SEED repeats a run; the seed is printed either way.
inline std::mt19937_64 random_source(const char* test) {
  const char* given = std::getenv("STROBE_SEED");
  const unsigned long seed = given ? std::strtoul(given, nullptr, 10) : 20250211UL;
  std::printf("[%s: STROBE_SEED=%lu] ", test, seed);
  return std::mt19937_64(seed);
}

struct Noise {
  impact::Motion touchdown;
  impact::Motion lift_off;
  double e = 0.0;
};

/// Lift-off that the impulse balance gives for each observation's touchdown and e.
inline std::vector<impact::Observation> true_rebounds(std::vector<impact::Observation> observations,
                                                      const impact::ParameterValues& p) {
  for (impact::Observation& o : observations) {
    const BalanceOutput out = bounce({.vx = o.touchdown.vx_mps,
                                      .vy = o.touchdown.vy_mps,
                                      .omega = o.touchdown.omega_radps,
                                      .e = o.e,
                                      .mu = p[0],
                                      .e_x = p[1],
                                      .offset_m = p[2],
                                      .reference_mps = p[3],
                                      .alpha = p[4],
                                      .radius_m = ball::kThesisDiameter_m / 2.0L});
    o.lift_off.vx_mps = static_cast<double>(out.vx);
    o.lift_off.vy_mps = -o.e * o.touchdown.vy_mps;
    o.lift_off.omega_radps = static_cast<double>(out.omega);
  }
  return observations;
}

/// The truth as it would be measured, with the noise stated.
inline std::vector<impact::Observation> measured(std::vector<impact::Observation> truth, const Noise& noise,
                                                 std::mt19937_64& source) {
  std::normal_distribution<double> normal;
  const auto disturb = [&](impact::Motion& m, const impact::Motion& sd) {
    m.vx_mps += sd.vx_mps * normal(source);
    m.vy_mps += sd.vy_mps * normal(source);
    m.omega_radps += sd.omega_radps * normal(source);
  };
  for (impact::Observation& o : truth) {
    disturb(o.touchdown, noise.touchdown);
    disturb(o.lift_off, noise.lift_off);
    o.e += noise.e * normal(source);
    o.touchdown_sd = noise.touchdown;
    o.lift_off_sd = noise.lift_off;
    o.e_sd = noise.e;
  }
  return truth;
}

inline std::vector<impact::Observation> conditions(thesis::Version version = thesis::Version::corrected,
                                                   impact::Spread spread = impact::Spread::replicate) {
  return impact::observations_of(thesis_data(version).conditions, spread);
}

}  // namespace strobe::testing
