// Measures the cost of a shot on this machine. The only part of planning that reads a clock.
#pragma once

#include <span>
#include <vector>

#include "sim/scene/model.hpp"
#include "sim/scene/scene.hpp"
#include "sim/shoot/shoot.hpp"

namespace strobe::sim {

/// Microseconds of one shot for each model: the mean of the fastest of kCostRounds rounds, in which the
/// models alternate. A round of a model lasts kCostRound_s or five shots, whichever is longer. Fails for
/// settings out of range.
inline constexpr int kCostRounds = 4;
inline constexpr double kCostRound_s = 0.02;
Result<std::vector<double>> shot_costs_us(const Scene& scene, std::span<const Model> models,
                                          const ShootSettings& settings);

}  // namespace strobe::sim
