#include "common/reduction/spin_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace strobe::reduction {

namespace {

double shortest_interval_s(const std::vector<EquatorReading>& readings) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < readings.size(); ++i)
    shortest = std::min(shortest, readings[i + 1].time_s - readings[i].time_s);
  return shortest;
}

}  // namespace

bool spins_contradict_friction(const Readout& readout, const ShotFit& fit) {
  constexpr double kMaxInterval_s = 7e-3;
  constexpr double kGap = 1.5;
  constexpr double kLargestOffset = 0.5;  // of the radius
  const Quantities& value = readout.value;
  const auto& before = value[Quantity::omega_td_radps];
  const auto& after = value[Quantity::omega_lo_radps];
  const auto& vx_before = value[Quantity::vx_td_mps];
  const auto& vx_after = value[Quantity::vx_lo_mps];
  const auto& vy_before = value[Quantity::vy_td_mps];
  const auto& vy_after = value[Quantity::vy_lo_mps];
  if (!before || !after || !vx_before || !vx_after || !vy_before || !vy_after) return false;
  const auto [shorter_s, interval_s] =
      std::minmax({shortest_interval_s(fit.equators[0]), shortest_interval_s(fit.equators[1])});
  if (!(interval_s > 0.0) || interval_s > kMaxInterval_s) return false;
  const ball::Ball& ball = fit.observations.ball;
  // As speeds of the rim, times alpha: no quotient of a ball's size overflows.
  const double lever_m = ball.alpha * ball.radius_m();
  const double contradiction_mps = std::abs(lever_m * (*after - *before) - (*vx_after - *vx_before));
  const double half_turn_mps = lever_m * std::numbers::pi / interval_s;
  if (interval_s <= kGap * shorter_s) return contradiction_mps > 0.5 * half_turn_mps;
  return contradiction_mps > half_turn_mps - kLargestOffset * (*vy_after - *vy_before);
}

}  // namespace strobe::reduction
