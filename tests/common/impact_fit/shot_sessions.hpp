// Sessions of shots as the simulator fires and the reduction reads them, with known coefficients of the contact mechanics,
// to hold the posterior of `strobe fit --model ode` against. The shots know nothing of the fit: machine, flight, flashes,
// digitizing by hand and the reduction's estimator stand between their truth and their numbers. Thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/impact/fit/model_fit.hpp"
#include "common/result.hpp"
#include "sim/scene/scene.hpp"

namespace strobe::testing {

struct ShotSession {
  std::vector<impact::Observation> shots;
  impact::ParameterValues truth{};
  impact::FitOptions options;  ///< those of `strobe fit --model ode FILE`
  int without_numbers = 0;     ///< shots that `strobe fit` would leave out
};

/// The shipped scenes of the thesis's 21 conditions.
Result<std::vector<sim::Scene>> scenes_of_conditions();

/// mu .4….7, stiffness_ratio 1.1…1.8, damping_ratio .4…1, offset_share .08….25 and alpha .52….6 are drawn, the offset's
/// reference speed is the mechanics' own; so many shots of each scene. Each scene's machine, restitution and dwell time
/// scatter as they do there.
Result<ShotSession> shoot_session(const std::vector<sim::Scene>& scenes, int shots_of_each,
                                  std::uint64_t seed);

}  // namespace strobe::testing
