#include "tests/studies/trade/known_impacts.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
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

namespace {

double golden_least(const std::function<double(double)>& of, double low, double high) {
  constexpr double kRatio = 0.6180339887498949;
  double a = high - kRatio * (high - low), b = low + kRatio * (high - low), of_a = of(a);
  double of_b = of(b);
  for (int i = 0; i < 30; ++i) {
    if (of_a < of_b) {
      high = b;
      b = a;
      of_b = of_a;
      of_a = of(a = high - kRatio * (high - low));
    } else {
      low = a;
      a = b;
      of_a = of_b;
      of_b = of(b = low + kRatio * (high - low));
    }
  }
  return 0.5 * (low + high);
}

double sum_of_squares(const std::vector<KnownImpact>& known, const Grip& grip) {
  double sum = 0.0;
  for (const KnownImpact& k : known) {
    const auto rebound = impact::grip(k.scene.ball, k.scene.touchdown, coefficients(k.scene, grip));
    const double error = rebound ? lift_off_error(k.scene, rebound->lift_off, k.lift_off) : 1.0;
    sum += error * error;
  }
  return sum;
}

}  // namespace

impact::Coefficients coefficients(const ImpactScene& scene, const Grip& grip) {
  return {.e = scene.contact.e,
          .mu = scene.contact.mu * grip.mu_factor,
          .e_x = grip.e_x,
          .offset_m = grip.offset_m};
}

double lift_off_error(const ImpactScene& scene, const impact::Motion& got, const impact::Motion& want) {
  const double spin = scene.ball.radius_m() * (got.omega_radps - want.omega_radps);
  return std::hypot(got.vx_mps - want.vx_mps, got.vy_mps - want.vy_mps, spin) / scene.speed_mps();
}

Grip calibrated_over(const std::vector<KnownImpact>& known, bool with_offset) {
  Grip grip;
  for (int round = 0; round < (with_offset ? 4 : 1); ++round) {
    grip.e_x = golden_least(
        [&](double e_x) {
          return sum_of_squares(known, {.e_x = e_x, .offset_m = grip.offset_m, .mu_factor = 1.0});
        },
        -0.9, 0.9);
    if (!with_offset) continue;
    grip.offset_m = golden_least(
        [&](double offset_m) {
          return sum_of_squares(known, {.e_x = grip.e_x, .offset_m = offset_m, .mu_factor = 1.0});
        },
        0.0, 0.012);
  }
  return grip;
}

Grip calibrated_at(const ImpactScene& scene) {
  const auto run = impact::simulate(scene.ball, scene.touchdown, scene.contact);
  if (!run) return {};
  const double rim = scene.ball.radius_m() * scene.touchdown.omega_radps;
  const double slip = scene.touchdown.vx_mps + rim;
  const double rolling = 0.5 * (scene.touchdown.vx_mps - rim);
  Grip grip;
  if (run->regime == Regime::grips)
    grip.e_x = std::clamp(-run->slip_lo_mps / slip, -1.0, 1.0);
  else
    grip.mu_factor = std::min(1.0, std::abs(run->impulse_ratio) / scene.contact.mu);
  const double share = rolling / std::hypot(rolling, impact::kOffsetReferenceSpeed_mps);
  grip.offset_m = std::clamp(run->mean_offset_m / share, 0.0, 0.9 * scene.ball.radius_m());
  if (!std::isfinite(grip.e_x)) grip.e_x = 0.0;
  if (!std::isfinite(grip.offset_m)) grip.offset_m = 0.0;
  return grip;
}

}  // namespace strobe::studies::trade
