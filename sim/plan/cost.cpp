#include "sim/plan/cost.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

namespace strobe::sim {

namespace {

constexpr int kMinShots = 5;

double mean_us(Shooter& shooter) {
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  double elapsed_s = 0.0;
  int shots = 0;
  while (shots < kMinShots || elapsed_s < kCostRound_s) {
    shooter.shoot(++shots);
    elapsed_s = std::chrono::duration<double>(Clock::now() - start).count();
  }
  return 1e6 * elapsed_s / shots;
}

}  // namespace

Result<std::vector<double>> shot_costs_us(const Scene& scene, std::span<const Model> models,
                                          const ShootSettings& settings) {
  std::vector<Shooter> shooters;
  for (const Model& model : models) {
    auto shooter = Shooter::make(scene, 1, model, settings);
    if (!shooter) return tl::unexpected(shooter.error());
    shooters.push_back(std::move(*shooter));
  }
  std::vector<double> costs(models.size(), std::numeric_limits<double>::infinity());
  for (int round = 0; round < kCostRounds; ++round) {
    for (std::size_t i = 0; i < shooters.size(); ++i) costs[i] = std::min(costs[i], mean_us(shooters[i]));
  }
  return costs;
}

}  // namespace strobe::sim
