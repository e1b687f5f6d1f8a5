#include "tests/studies/trade/impact_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/common/reduction/simulated_shot.hpp"

namespace strobe::studies::trade {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

impact::Motion motion(double speed_mps, double angle_rad, double omega_radps) {
  return {speed_mps * std::cos(angle_rad), speed_mps * std::sin(angle_rad), omega_radps};
}

}  // namespace

double ImpactScene::speed_mps() const { return std::hypot(touchdown.vx_mps, touchdown.vy_mps); }

std::vector<ImpactScene> practical_impacts(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<ImpactScene> scenes;
  for (int i = 0; i < count; ++i) {
    ImpactScene s;
    s.name = fmt::format("{}", i);
    s.ball = {.diameter_m = between(0.0635, 0.0686), .mass_kg = between(0.056, 0.0594), .alpha = 0.0};
    s.ball.alpha = between(0.5, ball::kThinShellAlpha);
    const double speed = std::exp(between(0.0, std::log(60.0)));
    const double most = std::min(600.0, speed / s.ball.radius_m());
    const double angle = between(-85.0, -5.0) * kDegree;
    s.touchdown = motion(speed, angle, between(-most, most));
    s.contact.e = between(0.5, 0.9);
    s.contact.mu = between(0.3, 0.9);
    s.contact.dwell_s = between(3e-3, 6.5e-3);
    s.contact.stiffness_ratio = std::exp(between(std::log(0.7), std::log(2.5)));
    s.contact.damping_ratio = std::exp(between(std::log(0.2), std::log(1.5)));
    s.contact.offset_share = between(0.0, 0.25);
    scenes.push_back(s);
  }
  return scenes;
}

std::vector<ImpactScene> thesis_impacts() {
  std::vector<ImpactScene> scenes;
  for (const test::Bounce& b : test::thesis_bounces()) {
    ImpactScene s{.name = b.label,
                  .ball = {.alpha = impact::kContactAlpha},
                  .touchdown = {b.vx_td, b.vy_td, b.omega_td},
                  .contact = {}};
    s.contact.e = -b.vy_lo / b.vy_td;
    s.contact.dwell_s = b.dwell_s;
    scenes.push_back(s);
  }
  return scenes;
}

std::vector<ImpactScene> shots_of(const ImpactScene& scene, int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto normal = [&](double sd) { return std::normal_distribution<double>(0.0, 1.0)(random) * sd; };
  std::vector<ImpactScene> shots;
  for (int i = 0; i < count; ++i) {
    ImpactScene s = scene;
    const double angle = std::atan2(scene.touchdown.vy_mps, scene.touchdown.vx_mps);
    s.touchdown = motion(scene.speed_mps() * (1.0 + normal(0.02)),
                         std::clamp(angle + normal(0.6 * kDegree), -88.0 * kDegree, -2.0 * kDegree),
                         scene.touchdown.omega_radps + normal(10.0));
    s.contact.e = std::clamp(s.contact.e + normal(0.01), 0.2, 0.98);
    s.contact.mu = std::max(0.05, s.contact.mu + normal(0.03));
    s.contact.dwell_s *= 1.0 + normal(0.015);
    shots.push_back(s);
  }
  return shots;
}

}  // namespace strobe::studies::trade
