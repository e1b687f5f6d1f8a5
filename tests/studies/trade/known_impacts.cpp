#include "tests/studies/trade/known_impacts.hpp"

#include <algorithm>
#include <thread>

#include "tests/common/contact_ode/reference.hpp"
#include "tests/studies/in_parallel.hpp"

namespace strobe::studies::trade {

namespace {

// With twice as many intervals the lift-off changes by less than reference_error() says.
constexpr int kIntervals = 160;

impact::Motion exact_lift_off(const ImpactScene& s, int intervals) {
  const auto exact = testing::reference_contact(s.ball, s.touchdown, s.contact, intervals);
  return {static_cast<double>(exact.vx_mps), static_cast<double>(exact.vy_mps),
          static_cast<double>(exact.omega_radps)};
}

}  // namespace

std::vector<KnownImpact> known_impacts(const std::vector<ImpactScene>& scenes) {
  std::vector<KnownImpact> known(scenes.size());
  in_parallel(scenes.size(), std::thread::hardware_concurrency(), [&](std::size_t i) {
    known[i] = {scenes[i], exact_lift_off(scenes[i], kIntervals)};
  });
  return known;
}

double reference_error(const std::vector<ImpactScene>& scenes, std::size_t most) {
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(most, scenes.size()); ++i) {
    const auto coarse =
        testing::reference_contact(scenes[i].ball, scenes[i].touchdown, scenes[i].contact, kIntervals);
    const auto fine =
        testing::reference_contact(scenes[i].ball, scenes[i].touchdown, scenes[i].contact, 2 * kIntervals);
    const testing::Quad spin = scenes[i].ball.radius_m() * (coarse.omega_radps - fine.omega_radps);
    const testing::Quad vx = coarse.vx_mps - fine.vx_mps;
    const testing::Quad vy = coarse.vy_mps - fine.vy_mps;
    const testing::Quad difference = sqrt(vx * vx + vy * vy + spin * spin);
    worst = std::max(worst, static_cast<double>(difference) / scenes[i].speed_mps());
  }
  return worst;
}

}  // namespace strobe::studies::trade
