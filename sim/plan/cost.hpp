// What a shot costs on this machine, measured. Reads a clock; everything else of a plan does not.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

/// Microseconds of one shot for each model: of kCostRounds rounds, in which the models take turns, the
/// fastest one's mean. A round of a model lasts kCostRound_s or five shots, whichever is longer. Fails for
/// settings out of range.
inline constexpr int kCostRounds = 4;
inline constexpr double kCostRound_s = 0.02;
Result<std::vector<double>> shot_costs_us(const Scene& scene, std::span<const Model> models,
                                          const ShootSettings& settings);

}  // namespace strobe::sim
